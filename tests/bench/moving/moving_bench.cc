// dacrt's drop-in beside Embree on scenes that change from frame to frame: see --help.
#include <span>
#include <string>

#include "bench_scene.h"
#include "cell_runs.h"
#include "command_line.h"
#include "errors.h"
#include "format.h"
#include "moving_cells.h"
#include "moving_contest.h"
#include "moving_options.h"
#include "moving_report.h"
#include "processor.h"
#include "progress.h"

namespace dacrt::bench {
namespace {

void MeasureTogether(const MovingOptions& options, const BenchScene& scene,
                     std::span<const MovingCell> cells, Progress& progress,
                     MovingResults& results) {
  progress.Show(Name(cells.front()) + ": commits");
  MovingContest contest(scene, *FindChangeKind(cells.front().change), cells.front().threads);
  for (const MovingCell& cell : cells) {
    const std::string name = Name(cell);
    const auto show = [&](const std::string& step) { progress.Show(name + ": " + step); };
    try {
      const auto result = contest.Measure(cell, options.repeat, show);
      if (result) results.cells.push_back(*result);
      // After every cell: what was measured is not lost if the run ends early.
      Save(options.outputs, results);
      progress.Finish(name +
                      (result ? ": x " + Fixed(result->Ratio(), 2) : ": there are no such rays"));
    } catch (const Disagreement& error) {
      throw Disagreement(name + ": " + error.what());
    }
  }
}

int Main(int argc, char** argv) {
  const auto options = ParseMovingOptions(argc, argv);
  if (!options) return kSuccess;
  MovingResults results{.command = CommandText("tests/bench/run moving", argc, argv),
                        .processor = ProcessorName(),
                        .repeat = options->repeat,
                        .cells = {}};
  return MeasureMatrix(
      *options, results,
      [&](const BenchScene& scene, std::span<const MovingCell> cells, Progress& progress) {
        MeasureTogether(*options, scene, cells, progress, results);
      });
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("moving_bench", [=] { return dacrt::bench::Main(argc, argv); });
}
