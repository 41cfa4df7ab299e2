// dacrt's drop-in beside Embree, in one process, on the same meshes and the same rays: see --help.
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "embree_contest.h"
#include "errors.h"
#include "format.h"
#include "output_file.h"
#include "processor.h"
#include "progress.h"
#include "table.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

constexpr char kDescription[] =
    "Measures dacrt's drop-in against Embree itself on one thread, in turn, with Embree at its\n"
    "best: the faster of AVX2 and AVX-512, of low and medium build quality, of coherent and\n"
    "incoherent streams and single rays.";

constexpr char kFooter[] = R"(
One shot: commit of a scene not seen before, and the first call. Steady: a later call.
Ratios are Embree's time over dacrt's.

Exit codes: 0 measured, 1 a library or memory cannot be had, 2 bad command line, 3 measured, but a
scene could not be read, 4 the libraries found different hits, 5 the output cannot be written.)";

struct Options {
  std::vector<std::string> scenes = {"hall-260k"};
  std::string folder = DACRT_SCENES_DIR;
  std::vector<RayKind> kinds = RayKinds();
  std::vector<Raster> rasters;
  int repeat = 3;
  std::string json;
};

std::optional<Options> ParseOptions(int argc, char** argv) {
  Options options;
  std::vector<std::string> kinds;
  for (const RayKind& kind : options.kinds) kinds.push_back(kind.name);
  const std::vector<std::string> all_kinds = kinds;
  std::vector<uint32_t> sides = {1024, 2048};

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.add_option("--scene", options.scenes, "Scenes, as method_bench takes them")
      ->capture_default_str()
      ->type_name("NAME|FILE");
  app.add_option("--scenes-dir", options.folder, "Folder of the PLY scenes")
      ->envname("DACRT_SCENES_DIR")
      ->type_name("DIR");
  app.add_option("--kind", kinds, "Kinds of rays")
      ->check(CLI::IsMember(all_kinds))
      ->type_name("KIND");
  app.add_option("--rays", sides, "N x N camera rays")->capture_default_str()->type_name("N");
  app.add_option("--repeat", options.repeat, "Rounds, of which the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--json", options.json, "Write all figures")->type_name("FILE");
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  std::erase_if(options.kinds, [&](const RayKind& kind) {
    return std::ranges::find(kinds, kind.name) == kinds.end();
  });
  for (const uint32_t side : sides) options.rasters.emplace_back(side);
  return options;
}

nlohmann::ordered_json ToJson(const Times& times) {
  return {{"commit_seconds", times.commit},
          {"first_seconds", times.first},
          {"steady_seconds", times.steady}};
}

nlohmann::ordered_json ToJson(const EmbreeResult& result) {
  return {{"scene", result.scene},
          {"triangles", result.triangles},
          {"kind", result.kind},
          {"rays", result.rays},
          {"embree_one_shot", Name(result.best_one_shot)},
          {"embree_steady", Name(result.best_steady)},
          {"embree", ToJson(result.embree)},
          {"dacrt", ToJson(result.dacrt)},
          {"one_shot_ratio", result.OneShotRatio()},
          {"steady_ratio", result.SteadyRatio()}};
}

class Benchmark {
 public:
  explicit Benchmark(const Options& options)
      : options_(options), progress_(options.scenes.size() * CellsAScene()) {}

  void Run() {
    Save();  // so that an output that cannot be written shows before measuring
    for (const std::string& name : options_.scenes) {
      progress_.Show(name + ": loading");
      try {
        BenchScene scene = SceneSource(name, options_.folder).Load();
        scene.mesh.positions.push_back(0);  // Embree reads it with the last vertex
        MeasureScene(scene);
      } catch (const UnreadableScene& error) {
        is_complete_ = false;
        progress_.Say(error.what());
        progress_.Skip(CellsAScene());
      }
    }
  }

  bool is_complete() const { return is_complete_; }

  void Print(std::ostream& out) const {
    constexpr std::size_t kLeft = 2;
    Table table({"scene", "rays", "number", "Embree commit", "trace", "steady", "dacrt commit",
                 "trace", "steady", "one shot x", "steady x", "Embree's best, one shot"},
                kLeft);
    for (const EmbreeResult& result : results_) {
      table.Add({result.scene, result.kind, Grouped(result.rays),
                 Seconds(Median(result.embree.commit)), Seconds(Median(result.embree.first)),
                 Seconds(Median(result.embree.steady)), Seconds(Median(result.dacrt.commit)),
                 Seconds(Median(result.dacrt.first)), Seconds(Median(result.dacrt.steady)),
                 Fixed(result.OneShotRatio(), 2), Fixed(result.SteadyRatio(), 2),
                 Name(result.best_one_shot)});
    }
    out << ProcessorName() << ", one thread, median of " << options_.repeat
        << ", seconds; x: Embree's time over dacrt's\n\n";
    table.Print(out);
  }

 private:
  std::size_t CellsAScene() const { return options_.kinds.size() * options_.rasters.size(); }

  void MeasureScene(const BenchScene& scene) {
    for (const Raster& raster : options_.rasters) {
      for (const RayKind& kind : options_.kinds) {
        const std::string name =
            scene.name + ", " + kind.name + ", " + Squared(raster.rays_a_side());
        results_.push_back(
            contest_.Measure(scene, kind, raster, options_.repeat,
                             [&](const std::string& step) { progress_.Show(name + ": " + step); }));
        progress_.Finish(name + ": one shot x " + Fixed(results_.back().OneShotRatio(), 2) +
                         ", steady x " + Fixed(results_.back().SteadyRatio(), 2));
        Save();
      }
    }
  }

  // After every cell: what was measured is not lost if the run ends early.
  void Save() const {
    if (options_.json.empty()) return;
    nlohmann::ordered_json cells = nlohmann::ordered_json::array();
    for (const EmbreeResult& result : results_) cells.push_back(ToJson(result));
    const nlohmann::ordered_json json = {{"benchmark", "embree_bench"},
                                         {"processor", ProcessorName()},
                                         {"threads", 1},
                                         {"repeat", options_.repeat},
                                         {"cells", cells}};
    WriteFile(options_.json, JsonText(json));
  }

  const Options& options_;
  Progress progress_;
  EmbreeContest contest_;
  std::vector<EmbreeResult> results_;
  bool is_complete_ = true;
};

int Main(int argc, char** argv) {
  const auto options = ParseOptions(argc, argv);
  if (!options) return kSuccess;
  Benchmark benchmark(*options);
  benchmark.Run();
  benchmark.Print(std::cout);
  return benchmark.is_complete() ? kSuccess : kUnreadableScene;
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("embree_bench", [=] { return dacrt::bench::Main(argc, argv); });
}
