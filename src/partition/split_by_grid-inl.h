// Splitting a large subset of the kept partition: one pass sorts its triangles into the cells of a
// grid, nodes are made over the cells, and one pass moves the triangles.
// Pantaleoni, Luebke, "HLBVH: hierarchical LBVH construction for real-time ray tracing of dynamic
// geometry", HPG 2010: the same two stages, with the surface area heuristic over the cells.

#if defined(DACRT_PARTITION_SPLIT_BY_GRID_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SPLIT_BY_GRID_INL_H_
#undef DACRT_PARTITION_SPLIT_BY_GRID_INL_H_
#else
#define DACRT_PARTITION_SPLIT_BY_GRID_INL_H_
#endif

#include <algorithm>
#include <new>

#include "partition/grid.h"
#include "partition/split_subset-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Leaves that are subsets of the next level.
struct SubsetLeaves {
  size_t most() const { return most_triangles; }
  /// A cell alone can not be split here.
  bool IsLeaf(const WeighedRange& child) const {
    return child.weight <= most_triangles || child.range.count() == 1;
  }
  uint16_t Child(const WeighedRange& child) {
    grid.subsets[count] = {static_cast<uint32_t>(child.range.begin),
                           static_cast<uint32_t>(child.range.end)};
    return WideNode::Child(WideNode::kSubset, count++ - first);
  }
  uint32_t first_other() {
    first = count;
    return static_cast<uint32_t>(count);
  }

  Grid& grid;
  size_t most_triangles;
  size_t count = 0;
  size_t first = 0;
};

/// Sorts the triangles of a subset into cells. Returns the number of those that are not empty,
/// which then stand first in grid.cells.
inline size_t SortIntoCells(KeptPartition& kept, std::span<const uint32_t> triangles,
                            const Box& centers, Grid& grid) {
  for (size_t cell = 0; cell < grid.CellCount(); ++cell) {
    const Box empty = Box::Empty();
    std::copy_n(empty.lower, 3, grid.cells[cell].lower);
    std::copy_n(empty.upper, 3, grid.cells[cell].upper);
    grid.place[cell] = 0;
  }
  const BinMap map(centers, grid.cells_an_axis);
  // Triangles with one centre are told apart by their order.
  const bool by_order = !map.IsUseful(0) && !map.IsUseful(1) && !map.IsUseful(2);
  for (size_t i = 0; i < triangles.size(); ++i) {
    const auto [lower, upper] = BoundUsable(kept.meshes(), kept.meshes().Locate(triangles[i]));
    HWY_ALIGN int32_t number[4];
    map.Map(TwiceCenter(lower, upper), number);
    const size_t cell = by_order
                            ? i * grid.CellCount() / triangles.size()
                            : (static_cast<size_t>(number[2]) * grid.cells_an_axis + number[1]) *
                                      grid.cells_an_axis +
                                  number[0];
    grid.triangles[i] = triangles[i];
    grid.cell_of[i] = static_cast<uint16_t>(cell);
    TriangleRef& bounds = grid.cells[cell];
    Min(Corner::Load(bounds.lower), lower).Store(bounds.lower);
    Max(Corner::Load(bounds.upper), upper).Store(bounds.upper);
    ++grid.place[cell];
  }
  size_t used = 0;
  for (size_t cell = 0; cell < grid.CellCount(); ++cell) {
    if (grid.place[cell] == 0) continue;
    TriangleRef& ref = grid.cells[used++];
    ref = grid.cells[cell];
    // The names are scrap so far.
    ref.primitive = static_cast<uint32_t>(cell);
    ref.mesh = grid.place[cell];
  }
  return used;
}

inline Box CentersOf(KeptPartition& kept, std::span<const uint32_t> triangles) {
  CornerBounds centers;
  for (const uint32_t triangle : triangles) {
    const auto [lower, upper] = BoundUsable(kept.meshes(), kept.meshes().Locate(triangle));
    centers.Extend(TwiceCenter(lower, upper));
  }
  return centers.Get();
}

/// Returns the number of the root, or Subset::kNoRoom.
inline uint32_t SplitByGrid(KeptPartition& kept, const Subset& subset, SubsetScratch& scratch) {
  const auto triangles = kept.triangles().subspan(subset.begin, subset.count);
  const bool is_all = subset.count == kept.triangle_count();
  const Box centers = is_all ? kept.centers() : CentersOf(kept, triangles);
  Grid grid(subset.count);
  const size_t cells = SortIntoCells(kept, triangles, centers, grid);

  const WeighedRange all{MeasureTriangles(grid.cells, 0, cells), subset.count};
  const std::span<WideNode> nodes(grid.nodes, Grid::kMostNodes);
  SubsetLeaves leaves{grid, SubsetScratch::kTriangles};
  size_t count = 0;
  // Larger subsets where the nodes do not suffice, in very large scenes.
  for (; count == 0; leaves.most_triangles *= 4) {
    leaves.count = 0;
    count = NodeBuilder<Cells, SubsetLeaves>(grid.cells, leaves, nodes, scratch).Build(all);
  }
  uint32_t first_subset;
  const uint32_t root = KeepNodes(kept, nodes.first(count), leaves.count, first_subset);
  if (root == Subset::kNoRoom) return root;

  uint32_t next = 0;
  for (size_t i = 0; i < leaves.count; ++i) {
    Subset& child = kept.subset(static_cast<uint32_t>(first_subset + i));
    child.begin = subset.begin + next;
    // Children were listed in the order of their cells within a node only; so each takes its
    // triangles from where the last one ended.
    for (uint32_t cell = grid.subsets[i].begin; cell < grid.subsets[i].end; ++cell) {
      grid.place[grid.cells[cell].primitive] = next;
      next += grid.cells[cell].mesh;
    }
    child.count = subset.begin + next - child.begin;
    child.root = Subset::kUnsplit;
  }
  for (size_t i = 0; i < triangles.size(); ++i) {
    triangles[grid.place[grid.cell_of[i]]++] = grid.triangles[i];
  }
  return root;
}

/// The root of a subset, which is split now if it is not yet; Subset::kNoRoom if it can not be.
/// Threads that come while another one splits it wait.
inline uint32_t RootOf(KeptPartition& kept, uint32_t number, SubsetScratch& scratch) {
  Subset& subset = kept.subset(number);
  uint32_t root = subset.root.load(std::memory_order_acquire);
  if (HWY_LIKELY(root <= Subset::kNoRoom)) return root;
  uint32_t expected = Subset::kUnsplit;
  if (!subset.root.compare_exchange_strong(expected, Subset::kBeingSplit)) {
    subset.root.wait(Subset::kBeingSplit);
    return std::min(subset.root.load(std::memory_order_acquire), Subset::kNoRoom);
  }
  uint32_t next;  // what those that come later find
  try {
    next = root = subset.count > SubsetScratch::kTriangles
                      ? SplitByGrid(kept, subset, scratch)
                      : SplitSmallSubset(kept, subset, scratch);
  } catch (const std::bad_alloc&) {
    root = Subset::kNoRoom;
    next = Subset::kUnsplit;  // there may be memory the next time
  }
  subset.root.store(next, std::memory_order_release);
  subset.root.notify_all();
  return root;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_BY_GRID_INL_H_
