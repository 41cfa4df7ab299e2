// dacrt's drop-in beside Embree on scenes that change from frame to frame: see --help.
#include <algorithm>
#include <iostream>
#include <span>
#include <string>
#include <utility>
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

bool AreOfOneScene(const MovingCell& a, const MovingCell& b) { return a.scene == b.scene; }

class Benchmark {
 public:
  Benchmark(const MovingOptions& options, std::vector<MovingCell> cells, MovingResults& results)
      : options_(options), cells_(std::move(cells)), progress_(cells_.size()), results_(results) {}

  // False if a scene could not be read.
  bool Run() {
    Save(options_.outputs, results_);  // so that an output that cannot be written shows at once
    bool is_complete = true;
    ForEachRun(
        std::span(std::as_const(cells_)), AreOfOneScene, [&](std::span<const MovingCell> cells) {
          progress_.Show(cells.front().scene + ": loading");
          try {
            const BenchScene scene =
                SceneSource(cells.front().scene, options_.folder).LoadForEmbree();
            ForEachRun(
                cells,
                [](const MovingCell& a, const MovingCell& b) { return AreMeasuredTogether(a, b); },
                [&](std::span<const MovingCell> group) { Measure(scene, group); });
          } catch (const UnreadableScene& error) {
            is_complete = false;
            progress_.Say(error.what());
            progress_.Skip(cells.size());
          }
        });
    return is_complete;
  }

 private:
  void Measure(const BenchScene& scene, std::span<const MovingCell> cells) {
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
  const std::vector<MovingCell> cells_;
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
  if (options->outputs.resume) Resume(options->outputs.json, results);
  std::vector<MovingCell> cells = options->cells;
  std::erase_if(cells, [&](const MovingCell& cell) {
    return std::ranges::find(results.cells, cell, &MovingResult::cell) != results.cells.end();
  });
  const bool is_complete = Benchmark(*options, std::move(cells), results).Run();
  PrintText(results, std::cout);
  return is_complete ? kSuccess : kUnreadableScene;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("moving_bench", [=] { return dacrt::bench::Main(argc, argv); });
}
