#include "moving_cells.h"

#include <algorithm>
#include <tuple>

#include "bench_scene.h"
#include "command_line.h"
#include "moving_content.h"

namespace dacrt::bench {
namespace {

using Strings = std::vector<std::string>;

constexpr char kHall[] = "hall-260k";

auto Group(const MovingCell& cell) { return std::tie(cell.scene, cell.change, cell.threads); }

// In the order of the blocks: scenes, then what is measured together.
void AddCells(const MovingBlock& block, const std::string& scene, std::vector<MovingCell>& cells) {
  for (const std::string& change : block.changes)
    for (const int threads : block.threads)
      for (const std::string& kind : block.kinds)
        for (const std::string& size : block.sizes) {
          const MovingCell cell{scene, change, kind, size, threads};
          if (std::ranges::find(cells, cell) != cells.end()) continue;
          // Behind the last with which it is measured together, if there is one.
          const auto last = std::find_if(
              cells.rbegin(), cells.rend(),
              [&](const MovingCell& other) { return AreMeasuredTogether(cell, other); });
          cells.insert(last == cells.rend() ? cells.end() : last.base(), cell);
        }
}

}  // namespace

const Strings& MovingRayKinds() {
  static const Strings kinds = {"primary", "diffuse"};
  return kinds;
}

std::vector<MovingBlock> ShortMovingBlocks(const std::string& folder,
                                           const std::vector<int>& threads) {
  const std::vector<int> one = {threads.front()};
  const Strings all = NamesOf(ChangeKinds()), sizes = NamesOf(FrameSizes());
  return {
      {PresentScenes({kHall, "sponza"}, folder), {"wave"}, MovingRayKinds(), sizes, one},
      {PresentScenes({kHall, "sponza"}, folder), all, MovingRayKinds(), {"1K", "10K", "100K"}, one},
      {PresentScenes({kHall, "sponza"}, folder),
       {"wave", "one-of-1000"},
       MovingRayKinds(),
       {"10K", "100K"},
       threads},
      {PresentScenes({"hall-75k", "dragon", "hall-1m"}, folder),
       {"wave", "replaced"},
       MovingRayKinds(),
       {"1K", "10K", "100K"},
       one},
      {{"hall-5m"}, {"wave"}, {"diffuse"}, {"100K"}, one},
  };
}

std::vector<MovingBlock> FullMovingBlocks(const std::string& folder,
                                          const std::vector<int>& threads) {
  return {{PresentScenes(SceneNames(), folder), NamesOf(ChangeKinds()), MovingRayKinds(),
           NamesOf(FrameSizes()), threads}};
}

std::vector<MovingCell> CellsOf(const std::vector<MovingBlock>& blocks) {
  Strings scenes;
  for (const MovingBlock& block : blocks) {
    for (const std::string& scene : block.scenes) {
      if (std::ranges::find(scenes, scene) == scenes.end()) scenes.push_back(scene);
    }
  }
  std::vector<MovingCell> cells;
  for (const std::string& scene : scenes) {
    for (const MovingBlock& block : blocks) {
      if (std::ranges::find(block.scenes, scene) != block.scenes.end()) {
        AddCells(block, scene, cells);
      }
    }
  }
  return cells;
}

bool AreMeasuredTogether(const MovingCell& a, const MovingCell& b) { return Group(a) == Group(b); }

}  // namespace dacrt::bench
