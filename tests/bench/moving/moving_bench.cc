// dacrt's drop-in beside Embree on scenes that change from frame to frame: see --help.
#include <iostream>
#include <span>
#include <string>
#include <vector>

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

class Benchmark {
 public:
  Benchmark(const MovingOptions& options, std::size_t cells, MovingResults& results)
      : options_(options), progress_(cells), results_(results) {}

  // False if a scene could not be read.
  bool Run(std::span<const MovingCell> cells) {
    return MeasureByScene(cells, options_.folder, progress_,
                          [this](const BenchScene& scene, std::span<const MovingCell> together) {
                            MeasureTogether(scene, together);
                          });
  }

 private:
  void MeasureTogether(const BenchScene& scene, std::span<const MovingCell> cells) {
    progress_.Show(Name(cells.front()) + ": commits");
    MovingContest contest(scene, *FindChangeKind(cells.front().change), cells.front().threads);
    for (const MovingCell& cell : cells) {
      const std::string name = Name(cell);
      const auto show = [&](const std::string& step) { progress_.Show(name + ": " + step); };
      try {
        const auto result = contest.Measure(cell, options_.repeat, show);
        if (result) results_.cells.push_back(*result);
        // After every cell: what was measured is not lost if the run ends early.
        Save(options_.outputs, results_);
        progress_.Finish(
            name + (result ? ": x " + Fixed(result->Ratio(), 2) : ": there are no such rays"));
      } catch (const Disagreement& error) {
        throw Disagreement(name + ": " + error.what());
      }
    }
  }

  const MovingOptions& options_;
  Progress progress_;
  MovingResults& results_;
};

int Main(int argc, char** argv) {
  const auto options = ParseMovingOptions(argc, argv);
  if (!options) return kSuccess;
  MovingResults results{.command = CommandText("tests/bench/run moving", argc, argv),
                        .processor = ProcessorName(),
                        .repeat = options->repeat,
                        .cells = {}};
  std::vector<MovingCell> cells = options->cells;
  if (options->outputs.resume) {
    Resume(options->outputs.json, results);
    DropMeasured(results, cells);
  }
  Save(options->outputs, results);  // an output that cannot be written shows before measuring
  const bool is_complete = Benchmark(*options, cells.size(), results).Run(cells);
  PrintText(results, std::cout);
  return is_complete ? kSuccess : kUnreadableScene;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("moving_bench", [=] { return dacrt::bench::Main(argc, argv); });
}
