#include "embree_plots.h"

#include <algorithm>
#include <set>
#include <vector>

#include "batch_size.h"
#include "command_line.h"
#include "format.h"
#include "isa.h"
#include "output_file.h"
#include "ratio_panels.h"
#include "ray_kind.h"

namespace dacrt::bench {
namespace {

bool IsPlotted(const Cell& cell) {
  return cell.geometry == "triangles" && cell.isa == IsasHere().front();
}

RatioLine LineOf(const std::vector<const CellResult*>& cells, const std::string& kind, int threads,
                 bool is_one_shot) {
  RatioLine line{(is_one_shot ? "one shot, " : "steady, ") + ThreadsText(threads), {}};
  for (const BatchSize& size : BatchSizes()) {
    const auto found = std::ranges::find_if(cells, [&](const CellResult* result) {
      const Cell& cell = result->cell;
      return cell.kind == kind && cell.size == size.name && cell.threads == threads &&
             (!is_one_shot || result->HasOneShot());
    });
    std::optional<double>& ratio = line.ratios.emplace_back();
    if (found == cells.end()) continue;
    ratio = is_one_shot ? (*found)->OneShotRatio() : (*found)->SteadyRatio();
  }
  return line;
}

}  // namespace

std::string EmbreePlot(const EmbreeResults& results, const std::string& scene) {
  std::vector<const CellResult*> cells;
  std::set<std::string> kinds;
  std::set<int> threads;
  for (const CellResult& result : results.cells) {
    if (result.cell.scene != scene || !IsPlotted(result.cell)) continue;
    cells.push_back(&result);
    kinds.insert(result.cell.kind);
    threads.insert(result.cell.threads);
  }
  std::vector<RatioPanel> panels;
  for (const RayKind& kind : RayKinds()) {
    if (!kinds.contains(kind.name)) continue;
    RatioPanel& panel = panels.emplace_back(RatioPanel{kind.name, {}});
    for (const int count : threads) {
      for (const bool is_one_shot : {true, false}) {
        panel.lines.push_back(LineOf(cells, kind.name, count, is_one_shot));
      }
    }
  }
  return DrawRatioPanels(scene + ": Embree's time over dacrt's, against the rays a call",
                         NamesOf(BatchSizes()), panels);
}

std::vector<std::string> WritePlots(const EmbreeResults& results,
                                    const std::filesystem::path& folder) {
  std::set<std::string> scenes;
  for (const CellResult& result : results.cells) {
    if (IsPlotted(result.cell)) scenes.insert(result.cell.scene);
  }
  std::vector<std::string> files;
  for (const std::string& scene : scenes) {
    const std::string stem = std::filesystem::path(scene).stem();  // of a name, the name
    files.push_back("embree-" + stem + ".svg");
    WriteFile(folder / files.back(), EmbreePlot(results, scene));
  }
  return files;
}

}  // namespace dacrt::bench
