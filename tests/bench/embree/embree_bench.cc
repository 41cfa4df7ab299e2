// dacrt's drop-in beside Embree, in one process, on the same meshes and the same rays: see --help.
#include <algorithm>
#include <span>
#include <string>

#include "batch_size.h"
#include "cell_list.h"
#include "cell_runs.h"
#include "command_line.h"
#include "embree_contest.h"
#include "embree_options.h"
#include "embree_report.h"
#include "errors.h"
#include "format.h"
#include "geometry_kind.h"
#include "memory_child.h"
#include "processor.h"
#include "progress.h"

namespace dacrt::bench {
namespace {

MemoryResult MeasureMemoryOfBoth(const Cell& cell, const BenchScene& scene, RayBuffer& rays) {
  const std::string config = DeviceConfig(cell.isa, cell.threads);
  return {.cell = cell,
          .triangles = scene.TriangleCount(),
          .rays = rays.rays().size(),
          .embree = MeasureMemoryInChild(DACRT_REAL_EMBREE, config, scene, cell.geometry, rays),
          .dacrt = MeasureMemoryInChild(DACRT_DROP_IN, config, scene, cell.geometry, rays)};
}

void MeasureTogether(const EmbreeOptions& options, const BenchScene& scene,
                     std::span<const Cell> cells, Progress& progress, EmbreeResults& results) {
  const Cell& first = cells.front();
  progress.Show(Name(first) + ": commits");
  const SceneContent content = FindGeometryKind(first.geometry)->make(scene);
  EmbreeContest contest(scene, content,
                        {.isa = first.isa,
                         .threads = first.threads,
                         .anew = std::ranges::any_of(cells, MeasuresOneShot),
                         .embree = DACRT_REAL_EMBREE,
                         .drop_in = DACRT_DROP_IN},
                        options.effort);
  for (const Cell& cell : cells) {
    const std::string name = Name(cell);
    const auto show = [&](const std::string& step) { progress.Show(name + ": " + step); };
    show("making rays");
    RayBuffer rays = contest.MakeRays(cell);
    const BatchSize& size = *FindBatchSize(cell.size);
    if (rays.rays().size() < (size.IsSlice() ? size.rays : 1)) {
      progress.Finish(name + ": there are no such rays");
      continue;
    }
    try {
      results.cells.push_back(contest.Measure(cell, show, rays));
    } catch (const Disagreement& error) {
      throw Disagreement(name + ": " + error.what());
    }
    if (MeasuresMemory(cell)) {
      show("memory");
      results.memory.push_back(MeasureMemoryOfBoth(cell, scene, rays));
    }
    // After every cell: what was measured is not lost if the run ends early.
    Save(options.outputs, results);
    const CellResult& result = results.cells.back();
    progress.Finish(
        name + (result.HasOneShot() ? ": one shot x " + Fixed(result.OneShotRatio(), 2) : ":") +
        " steady x " + Fixed(result.SteadyRatio(), 2));
  }
}

int Main(int argc, char** argv) {
  const auto options = ParseEmbreeOptions(argc, argv);
  if (!options) return kSuccess;
  EmbreeResults results{.command = CommandText("tests/bench/run embree", argc, argv),
                        .processor = ProcessorName(),
                        .repeat = options->effort.repeat,
                        .cells = {},
                        .memory = {}};
  return MeasureMatrix(
      *options, results,
      [&](const BenchScene& scene, std::span<const Cell> cells, Progress& progress) {
        MeasureTogether(*options, scene, cells, progress, results);
      });
}

}  // namespace
}  // namespace dacrt::bench

int main(int argc, char** argv) {
  return dacrt::bench::RunGuarded("embree_bench", [=] { return dacrt::bench::Main(argc, argv); });
}
