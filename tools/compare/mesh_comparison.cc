#include "mesh_comparison.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "batch_size.h"
#include "embree_contest.h"
#include "errors.h"
#include "format.h"
#include "geometry_kind.h"
#include "libraries.h"
#include "memory_child.h"
#include "output_file.h"
#include "processor.h"
#include "progress.h"
#include "ray_kind.h"
#include "table.h"
#include "timing.h"
#include "verdict.h"

namespace dacrt::compare {
namespace {

using namespace dacrt::bench;

constexpr char kGeometry[] = "triangles";

Form FormOf(const BatchSize& size) {
  if (size.rays == 1) return Form::kSingle;
  return size.IsStream() ? FormOfStream(size.rays) : Form::kPacket;
}

std::string Rate(const CellResult& result, double seconds) {
  return Fixed(static_cast<double>(result.rays) / seconds / 1e6, 2);
}

class MeshComparison {
 public:
  explicit MeshComparison(const Options& options)
      : options_(options),
        scene_(SceneSource(options.mesh, "").LoadForEmbree()),
        results_{"dacrt-compare " + options.mesh, ProcessorName(), options.repeat, {}, {}} {}

  int Run() {
    Measure();
    std::printf("%s: %s triangles, %s, %s\nEmbree: %s\ndacrt: %s\n\n", options_.mesh.c_str(),
                Grouped(scene_.TriangleCount()).c_str(), options_.isa.c_str(),
                ThreadsText(options_.threads).c_str(), options_.embree.c_str(),
                options_.drop_in.c_str());
    PrintScene();
    PrintCalls();
    const std::vector<std::string> verdict =
        Verdict(Parts(), nullptr, {memory().embree.peak_resident, memory().dacrt.peak_resident});
    for (const std::string& line : verdict) std::puts(line.c_str());
    if (!options_.json.empty()) {
      nlohmann::ordered_json json = ToJson(results_);  // as embree_bench has it
      json["verdict"] = verdict;
      WriteFile(options_.json, JsonText(json));
    }
    return kSuccess;
  }

 private:
  void Measure() {
    const SceneContent content = FindGeometryKind(kGeometry)->make(scene_);
    ContestSetup setup;
    setup.isa = options_.isa;
    setup.threads = options_.threads;
    setup.anew = true;
    setup.embree = options_.embree;
    setup.drop_in = options_.drop_in;
    const Effort effort{.repeat = options_.repeat,
                        .rounds_seconds = 0.3,
                        .slices_seconds = 0.1,
                        .sliced_side = 256};
    bench::Progress progress(options_.kinds.size() * options_.sizes.size() + 1);
    progress.Show("commit");
    EmbreeContest contest(scene_, content, setup, effort);
    for (const std::string& kind : options_.kinds) {
      for (const std::string& size : options_.sizes) {
        const std::string name = kind + " rays, " + size + " a call";
        const Cell cell{options_.mesh, kGeometry, options_.isa, kind, size, options_.threads};
        RayBuffer rays = contest.MakeRays(cell);
        const BatchSize& batch = *FindBatchSize(size);
        if (rays.rays().size() >= (batch.IsSlice() ? batch.rays : 1)) {
          results_.cells.push_back(contest.Measure(
              cell, [&](const std::string& step) { progress.Show(name + ": " + step); }, rays));
        }
        progress.Skip(1);
      }
    }
    progress.Show("memory");
    MeasureMemory();
    if (results_.cells.empty()) {
      throw UnreadableScene(options_.mesh + ": no ray of the view hits anything");
    }
  }

  /// Each library in a process of its own, with a picture of 64K primary rays.
  void MeasureMemory() {
    constexpr std::uint32_t kSide = 256;
    RaySource source(scene_, {});
    RayBuffer rays = source.Make(*FindRayKind("primary"), kSide, [](RayBuffer&) {});
    const std::string config = DeviceConfig(options_.isa, options_.threads);
    const std::vector<std::string> child = {OwnPath(), "--memory-child"};
    const auto measure = [&](const std::string& library) {
      return MeasureMemoryInChild(library, config, scene_, kGeometry, rays, child);
    };
    const Cell cell{options_.mesh, kGeometry, options_.isa, "primary", "64K", options_.threads};
    results_.memory.push_back({cell, scene_.TriangleCount(), rays.rays().size(),
                               measure(options_.embree), measure(options_.drop_in)});
  }

  const MemoryResult& memory() const { return results_.memory.front(); }

  /// The median of all commits.
  std::vector<double> Commits(Times CellResult::*library) const {
    std::vector<double> commits;
    for (const CellResult& result : results_.cells) {
      const std::vector<double>& own = (result.*library).commit;
      commits.insert(commits.end(), own.begin(), own.end());
    }
    return commits;
  }

  void PrintScene() const {
    Table table({"the scene", "Embree", "dacrt", "Embree / dacrt"}, 1);
    const auto add = [&](const char* name, double embree, double dacrt, int digits) {
      table.Add({name, Fixed(embree, digits), Fixed(dacrt, digits),
                 dacrt > 0 ? Fixed(embree / dacrt, 2) : ""});
    };
    const auto embree = Commits(&CellResult::embree), dacrt = Commits(&CellResult::dacrt);
    if (!embree.empty()) add("commit, ms", 1e3 * Median(embree), 1e3 * Median(dacrt), 2);
    const auto megabytes = [](std::size_t bytes) { return static_cast<double>(bytes) / 1e6; };
    add("kept after a picture, MB", megabytes(memory().embree.kept_resident),
        megabytes(memory().dacrt.kept_resident), 1);
    add("peak, MB", megabytes(memory().embree.peak_resident),
        megabytes(memory().dacrt.peak_resident), 1);
    table.Print(std::cout);
    std::puts("");
  }

  void PrintCalls() const {
    std::puts(
        "First pass: commit and call on a scene not seen before, ms. Later: M rays/s on a still "
        "scene.");
    Table table({"rays", "a call", "first: Embree", "dacrt", "ratio", "later: Embree", "dacrt",
                 "ratio", "hits %"},
                1);
    for (const CellResult& result : results_.cells) {
      std::vector<std::string> row = {result.cell.kind, result.cell.size};
      if (result.HasOneShot()) {
        row.push_back(Fixed(1e3 * result.embree.OneShot(), 2));
        row.push_back(Fixed(1e3 * result.dacrt.OneShot(), 2));
        row.push_back(Fixed(result.OneShotRatio(), 2));
      } else {
        row.resize(row.size() + 3);
      }
      row.push_back(Rate(result, result.embree.Steady()));
      row.push_back(Rate(result, result.dacrt.Steady()));
      row.push_back(Fixed(result.SteadyRatio(), 2));
      row.push_back(Fixed(100 * result.hits, 1));
      table.Add(std::move(row));
    }
    table.Print(std::cout);
    std::puts("");
  }

  std::vector<Compared> Parts() const {
    std::vector<Compared> parts;
    for (const CellResult& result : results_.cells) {
      const RayKind& kind = *FindRayKind(result.cell.kind);
      const BatchSize& size = *FindBatchSize(result.cell.size);
      const Kind asked = kind.query == Query::kAny ? Kind::kAny : Kind::kClosest;
      const std::string name = result.cell.kind + " rays, " + result.cell.size + " a call";
      // For a ray, so that a large call does not outweigh the others.
      const double rays = static_cast<double>(result.rays);
      parts.push_back({name + ", later passes", asked, FormOf(size), result.embree.Steady() / rays,
                       result.dacrt.Steady() / rays});
      if (!result.HasOneShot()) continue;
      parts.push_back({name + ", first pass", Kind::kCommit, FormOf(size),
                       result.embree.OneShot() / rays, result.dacrt.OneShot() / rays});
    }
    return parts;
  }

  const Options& options_;
  const BenchScene scene_;
  EmbreeResults results_;
};

}  // namespace

int CompareMesh(const Options& options) {
  if (!options.config.empty()) setenv("DACRT_CONFIG", options.config.c_str(), 1);
  return MeshComparison(options).Run();
}

}  // namespace dacrt::compare
