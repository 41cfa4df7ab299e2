#include "cell_list.h"

#include <algorithm>
#include <tuple>

#include "batch_size.h"
#include "bench_scene.h"
#include "command_line.h"
#include "geometry_kind.h"
#include "isa.h"
#include "ray_kind.h"

namespace dacrt::bench {
namespace {

using Strings = std::vector<std::string>;

bool Has(const Strings& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

Strings Without(Strings names, const Strings& others) {
  std::erase_if(names, [&](const std::string& name) { return Has(others, name); });
  return names;
}

// The other instruction sets than the best.
Strings LesserIsas() {
  Strings isas = IsasHere();
  isas.erase(isas.begin());
  return isas;
}

const Strings kTriangles = {"triangles"};
const Strings kCompact = {"compact"};
const Strings kCalls = {"1", "4", "8", "16"};
const Strings kFourAPixel = {"primary-4", "shadow-4"};
constexpr char kBox[] = "box-36";
constexpr char kHall[] = "hall-260k";

Strings OtherGeometries() {
  return Without(NamesOf(GeometryKinds()), {kTriangles.front(), kCompact.front()});
}

void AppendNew(const std::string& name, Strings& names) {
  if (!Has(names, name)) names.push_back(name);
}

// In the order of the blocks.
Strings ScenesOf(const std::vector<Block>& blocks) {
  Strings scenes;
  for (const Block& block : blocks) {
    for (const std::string& scene : block.scenes) AppendNew(scene, scenes);
  }
  return scenes;
}

bool IsFourAPixel(const std::string& kind) { return FindRayKind(kind)->samples_a_side > 1; }

auto Group(const Cell& cell) { return std::tie(cell.scene, cell.geometry, cell.isa, cell.threads); }

// Where a cell stands in its scene.
auto Rank(const Cell& cell) {
  const auto place = [](const Strings& names, const std::string& name) {
    return std::ranges::find(names, name) - names.begin();
  };
  static const Strings geometries = NamesOf(GeometryKinds()), isas = IsasHere(),
                       sizes = NamesOf(BatchSizes()), kinds = NamesOf(RayKinds());
  // Sizes before kinds: the primary hits of a picture are made once.
  return std::tuple(place(geometries, cell.geometry), place(isas, cell.isa), cell.threads,
                    IsFourAPixel(cell.kind), place(sizes, cell.size), place(kinds, cell.kind));
}

}  // namespace

const Strings& MainKinds() {
  static const Strings kinds = {"primary", "shadow", "ambient", "diffuse"};
  return kinds;
}

std::vector<Block> ShortBlocks(const std::string& folder, const std::vector<int>& threads) {
  const Strings best = {IsasHere().front()};
  const Strings real = PresentScenes({"sponza"}, folder);
  // What is fast over two scenes is not so over all: one of the dragon's cells was at 0.17, unseen.
  const Strings more =
      PresentScenes({"sibenik", "country_kitchen", "terrain_white_mountains", "dragon"}, folder);
  const auto with_hall = [](Strings others) {
    others.insert(others.begin(), kHall);
    return others;
  };
  const Strings scenes = with_hall(real);
  // Of some 270,000 triangles: what a call costs beside its rays shows less.
  const Strings called = {kBox, scenes.back()};
  const std::vector<int> one = {threads.front()};
  return {
      {scenes, kTriangles, best, MainKinds(), {"64", "1K", "4K", "64K", "1M"}, threads},
      {scenes, kTriangles, best, kFourAPixel, {"1M"}, one},
      {called, kTriangles, best, MainKinds(), kCalls, threads},
      {with_hall(more), kTriangles, best, MainKinds(), {"1", "16"}, one},
      {scenes, kTriangles, LesserIsas(), MainKinds(), {"64K", "256K"}, one},
      {{kHall}, OtherGeometries(), best, MainKinds(), {"64K"}, one},
      {{kHall}, kCompact, best, MainKinds(), {"64", "64K"}, one},
      {{"hall-1m"}, kTriangles, best, MainKinds(), {"64", "4K", "64K", "1M"}, one},
      {{"hall-1m"}, kCompact, best, {"diffuse"}, {"64K"}, one},
      {{kHall}, kTriangles, best, {"diffuse"}, {"16M"}, one},
      {more, kTriangles, best, MainKinds(), {"64K", "1M"}, one},
  };
}

std::vector<Block> FullBlocks(const std::string& folder, const std::vector<int>& threads) {
  const Strings best = {IsasHere().front()};
  const Strings scenes = PresentScenes(SceneNames(), folder);
  const Strings sizes = NamesOf(BatchSizes());
  return {
      {scenes, kTriangles, best, NamesOf(RayKinds()), sizes, threads},
      {scenes, kTriangles, LesserIsas(), NamesOf(RayKinds()), Without(sizes, {"4M", "16M"}),
       threads},
      {PresentScenes({kHall, "sponza"}, folder), Without(NamesOf(GeometryKinds()), kTriangles),
       best, MainKinds(), Without(sizes, {"4M", "16M"}), threads},
      {PresentScenes(MoreSceneNames(), folder),
       kTriangles,
       best,
       MainKinds(),
       {"1", "16", "64", "4K", "64K", "1M"},
       threads},
      {{"hall-1m"}, kCompact, best, {"diffuse"}, {"64K", "1M"}, threads},
  };
}

std::vector<Cell> CellsOf(const std::vector<Block>& blocks) {
  std::vector<Cell> cells;
  for (const std::string& scene : ScenesOf(blocks)) {
    std::vector<Cell> of_scene;
    for (const Block& block : blocks) {
      if (!Has(block.scenes, scene)) continue;
      for (const std::string& geometry : block.geometries)
        for (const std::string& isa : block.isas)
          for (const int threads : block.threads)
            for (const std::string& size : block.sizes)
              for (const std::string& kind : block.kinds) {
                if (IsFourAPixel(kind) && FindBatchSize(size)->IsSlice()) continue;
                of_scene.push_back({scene, geometry, isa, kind, size, threads});
              }
    }
    std::ranges::sort(of_scene, {}, Rank);
    const auto doubles = std::unique(of_scene.begin(), of_scene.end());
    cells.insert(cells.end(), of_scene.begin(), doubles);
  }
  return cells;
}

bool AreMeasuredTogether(const Cell& a, const Cell& b) { return Group(a) == Group(b); }

bool MeasuresOneShot(const Cell& cell) {
  const BatchSize& size = *FindBatchSize(cell.size);
  constexpr std::size_t kMostRays = 1 << 20;  // more take long, and a commit is little beside them
  return cell.geometry == "triangles" && cell.isa == IsasHere().front() &&
         Has(MainKinds(), cell.kind) && size.IsStream() && size.rays <= kMostRays &&
         cell.scene != kBox;
}

bool MeasuresMemory(const Cell& cell) {
  return (cell.geometry == "triangles" || cell.geometry == "compact") &&
         cell.isa == IsasHere().front() && cell.kind == "diffuse" && cell.scene != kBox &&
         (cell.size == "64K" || cell.size == "1M");
}

}  // namespace dacrt::bench
