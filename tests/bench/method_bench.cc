// The reproduction of the paper: see --help.
#include <nlohmann/json.hpp>

#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "errors.h"
#include "format.h"
#include "method_options.h"
#include "output_file.h"
#include "processor.h"
#include "progress.h"
#include "report.h"

namespace dacrt::bench {
namespace {

class Benchmark {
 public:
  Benchmark(const MethodOptions& options, std::string command)
      : options_(options), progress_(options.scenes.size() * FramesAScene()) {
    results_.command = std::move(command);
    results_.processor = ProcessorName();
    results_.instruction_set = Name(Device(options.algorithms.front().settings).instruction_set());
    results_.repeat = options.repeat;
  }

  const Results& results() const { return results_; }

  void Run() {
    Save();  // so that an output that cannot be written shows before hours of measuring
    for (const SceneSource& source : options_.scenes) {
      progress_.Show(source.name() + ": loading");
      try {
        const BenchScene scene = source.Load();
        MeasureScene(scene);
      } catch (const UnreadableScene& error) {
        results_.unreadable.push_back(error.what());
        progress_.Say(error.what());
        progress_.Skip(FramesAScene());
      }
    }
  }

 private:
  std::size_t FramesAScene() const {
    const std::size_t ablation = options_.ablation.empty() ? 0 : options_.kinds.size();
    return options_.rasters.size() * options_.kinds.size() + ablation;
  }

  void MeasureScene(const BenchScene& scene) {
    {
      const Contest algorithms(scene, options_.algorithms);
      for (const Raster& raster : options_.rasters) {
        for (const FrameKind* const kind : options_.kinds) {
          MeasureFrame(algorithms, *kind, raster, results_.comparison);
        }
      }
    }
    if (options_.ablation.empty()) return;
    const Contest ablation(scene, options_.ablation);
    for (const FrameKind* const kind : options_.kinds) {
      MeasureFrame(ablation, *kind, options_.ablation_raster, results_.ablation);
    }
  }

  void MeasureFrame(const Contest& contest, const FrameKind& kind, const Raster& raster,
                    std::vector<FrameResult>& frames) {
    const std::string name =
        contest.scene().name + ", " + kind.title + ", " + Squared(raster.rays_a_side());
    std::string at = name;  // and the pass
    try {
      frames.push_back(
          contest.Measure(kind, raster, options_.repeat, [&](const Pass& pass, std::size_t rays) {
            at = name + ": " + pass.name;
            progress_.Show(at + ", " + Grouped(rays) + " rays");
          }));
    } catch (const Disagreement& error) {
      throw Disagreement(at + ": " + error.what());
    }
    progress_.Finish(name + ": " + Summary(frames.back()));
    Save();
  }

  static std::string Summary(const FrameResult& frame) {
    std::string text = frame.methods[0].name + " " + Seconds(frame.Seconds(0)) + " s";
    for (std::size_t i = 1; i < frame.methods.size(); ++i) {
      text += ", " + frame.methods[i].name + " x " + Fixed(frame.Ratio(i, 0), 2);
    }
    return text;
  }

  // After every frame: what was measured is not lost if the run ends early.
  void Save() const {
    if (!options_.json.empty()) WriteFile(options_.json, JsonText(ToJson(results_)));
  }

  const MethodOptions& options_;
  Progress progress_;
  Results results_;
};

int Main(int argc, char** argv) {
  const auto options = ParseMethodOptions(argc, argv);
  if (!options) return kSuccess;
  Results results;
  {
    Benchmark benchmark(*options, CommandText("method_bench", argc, argv));
    benchmark.Run();
    results = benchmark.results();
  }
  PrintReport(results, std::cout);
  return results.unreadable.empty() ? kSuccess : kUnreadableScene;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("method_bench", [=] { return dacrt::bench::Main(argc, argv); });
}
