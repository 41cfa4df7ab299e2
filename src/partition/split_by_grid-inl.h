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
#include <optional>
#include <utility>

#include "partition/grid.h"
#include "partition/read_ahead-inl.h"
#include "partition/sort_into_cells-inl.h"
#include "partition/split_in_place-inl.h"
#include "partition/split_subset-inl.h"
#include "runtime/ordinary_arithmetic.h"
#include "runtime/tasks.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Ranges of cells are few, and all rays come through them: .2 ms for a million triangles.
constexpr ReinsertionEffort kOverCells{4, 0.25f};

/// Leaves that are subsets of the next level.
struct SubsetLeaves {
  /// A cell alone can not be split here.
  bool IsLeaf(const WeighedRange& child) const {
    return child.weight <= most_triangles || child.range.count() == 1;
  }
  ChildWord Child(const BinaryRange& child) {
    grid.subsets[count] = {child.begin, child.end, child.bounds.HalfArea()};
    return ChildWord::Subset(static_cast<uint32_t>(count++));
  }

  Grid& grid;
  size_t most_triangles;
  size_t count = 0;
};

/// Joins the cells of all parts. Returns the number of those that are not empty, which then stand
/// first in grid.cells.
template <class ForEachPart>
inline size_t JoinCells(Grid& grid, const ForEachPart& for_each_part) {
  for_each_part([&](const Grid::Part& one) HWY_ATTR {
    const Grid::Part some = grid.PartOf(one.number, grid.CellCount());
    for (size_t cell = some.begin; cell < some.end; ++cell) {
      TriangleRef& all = grid.cells[cell];
      Corner lower = Corner::Load(all.lower);
      Corner upper = Corner::Load(all.upper);
      uint32_t count = grid.place[cell];
      for (size_t part = 1; part < grid.parts; ++part) {
        const TriangleRef& bounds = grid.cells_of(part)[cell];
        lower = Min(lower, Corner::Load(bounds.lower));
        upper = Max(upper, Corner::Load(bounds.upper));
        count += grid.place_of(part)[cell];
      }
      lower.Store(all.lower);
      upper.Store(all.upper);
      all.primitive = static_cast<uint32_t>(cell);
      all.triangle_count = count;
    }
  });
  TriangleRef* const end =
      std::remove_if(grid.cells, grid.cells + grid.CellCount(),
                     [](const TriangleRef& c) { return c.triangle_count == 0; });
  return static_cast<size_t>(end - grid.cells);
}

/// Gives the triangles of a cell, part by part, the places from `next` on.
inline void PlaceCell(Grid& grid, size_t cell, uint32_t& next) {
  for (size_t part = 0; part < grid.parts; ++part) {
    next += std::exchange(grid.place_of(part)[cell], next);
  }
}

/// Makes subsets of ranges of cells, of which there are `count`, from number `first` on, and gives
/// the triangles of each cell, part by part, their places.
template <class ForEachPart>
inline void PlaceCells(KeptPartition& kept, const Subset& whole, Grid& grid, uint32_t first,
                       size_t count, const ForEachPart& for_each_part) {
  uint32_t next = whole.begin;
  // Children were listed in the order of their cells within a node only; so each takes its
  // triangles from where the last one ended.
  for (size_t i = 0; i < count; ++i) {
    const uint32_t begin = next;
    const Grid::CellRange& range = grid.subsets[i];
    for (uint32_t cell = range.begin; cell < range.end; ++cell) {
      next += grid.cells[cell].triangle_count;
    }
    DACRT_ASSERT(next > begin);
    kept.subset(static_cast<uint32_t>(first + i)).SetUnsplit(begin, next - begin, range.surface);
  }
  DACRT_ASSERT(next == whole.begin + whole.count);
  for_each_part([&](const Grid::Part& one) {
    const Grid::Part some = grid.PartOf(one.number, count);
    for (size_t i = some.begin; i < some.end; ++i) {
      uint32_t place = kept.subset(static_cast<uint32_t>(first + i)).begin - whole.begin;
      for (uint32_t cell = grid.subsets[i].begin; cell < grid.subsets[i].end; ++cell) {
        PlaceCell(grid, grid.cells[cell].primitive, place);
      }
    }
  });
}

/// Moves a part of the triangles to their places.
inline void MoveToPlaces(std::span<uint32_t> triangles, const Grid::Part& part, const Grid& grid) {
  uint32_t* const place = grid.place_of(part.number);
  for (size_t i = part.begin; i < part.end; ++i) {
    triangles[place[grid.cell_of[i]]++] = grid.triangles[i];
  }
}

/// Moves all parts. Where one cannot be moved for want of memory, all triangles stand as before:
/// otherwise some would stand in two places, and others in none.
template <class ForEachPart>
inline void MoveAll(std::span<uint32_t> triangles, const Grid& grid,
                    const ForEachPart& for_each_part) {
  try {
    for_each_part([&](const Grid::Part& part) { MoveToPlaces(triangles, part, grid); });
  } catch (...) {
    std::copy_n(grid.triangles, triangles.size(), triangles.begin());
    throw;
  }
}

/// Sorts the triangles of a subset into the cells of a grid.
template <class ForEachPart>
inline void SortIntoCells(const GeometryTable& geometries, std::span<const uint32_t> triangles,
                          const Box& centers, const Grid& grid, const ForEachPart& for_each_part) {
  for_each_part([&](const Grid::Part& part) HWY_ATTR {
    CellSorter sorter(grid, part.number, centers);
    const auto add = [&](size_t i, GeometryTable::Name name, const CornerSource& source) HWY_ATTR {
      const auto [lower, upper] = BoundUsable(geometries, source, name);
      sorter.Add(part.begin + i, triangles[part.begin + i], lower, upper);
    };
    ForEachReadAhead(geometries, triangles.subspan(part.begin, part.end - part.begin), add);
  });
}

/// Returns the number of the root, or Subset::kNoRoom. Where `tasks` is not null its threads work
/// together. Throws std::bad_alloc; the triangles stand as before then.
inline uint32_t SplitByGrid(KeptPartition& kept, Subset& subset, SubsetScratch& scratch,
                            TaskPool* tasks) {
  const auto triangles = kept.OrderOf(subset);
  const bool is_all = subset.count == kept.triangle_count();
  std::optional<Grid> sorted = is_all ? kept.TakeSorted() : std::nullopt;
  const bool is_sorted = sorted.has_value();
  const size_t parts = tasks ? Grid::PartsFor(subset.count, tasks->threads()) : 1;
  const bool fits = Grid::Bytes(subset.count, parts) <= sizeof(scratch.grid);
  Grid grid = is_sorted ? *std::move(sorted)
              : fits    ? Grid(subset.count, parts, scratch.grid)
                        : Grid(subset.count, parts, kept.account());
  const auto for_each_part = [&](const auto& body) {
    const auto call = [&](size_t i) { body(grid.PartOf(i)); };
    if (tasks && grid.parts > 1) return tasks->ForEach(grid.parts, call);
    for (size_t i = 0; i < grid.parts; ++i) call(i);
  };
  if (!is_sorted) {
    const Box centers = is_all ? kept.centers()
                               : SampleCenters(kept.geometries(), triangles.size(),
                                               [&](size_t i) { return triangles[i]; });
    SortIntoCells(kept.geometries(), triangles, centers, grid, for_each_part);
  }
  const size_t cells = JoinCells(grid, for_each_part);

  const WeighedRange all{MeasureTriangles(grid.cells, 0, cells), subset.count};
  const std::span<BinaryRange> ranges = grid.Ranges();
  const std::span<ExactNode> nodes = grid.Nodes();
  SubsetLeaves leaves{grid, SubsetScratch::kTriangles};
  size_t count = 0;
  // Larger subsets where the ranges or nodes do not suffice, in very large scenes.
  for (; count == 0; leaves.most_triangles *= 4) {
    leaves.count = 0;
    count = NodeBuilder(Cells(), kOverCells, grid.cells, leaves, ranges, nodes, scratch).Build(all);
  }
  uint32_t first_subset;
  const auto run = KeepNodes(kept, nodes.first(count), leaves.count, first_subset);
  if (!run) return Subset::kNoRoom;
  subset.node_slots = run->count;

  PlaceCells(kept, subset, grid, first_subset, leaves.count, for_each_part);
  MoveAll(triangles, grid, for_each_part);
  return run->first;
}

/// Splits a subset in the way that its size and the memory allow. Returns as above.
/// Throws std::bad_alloc where there is no memory for a small one.
inline uint32_t SplitSubset(KeptPartition& kept, Subset& subset, size_t rays,
                            SubsetScratch* scratch, TaskPool* tasks) {
  if (subset.count <= SubsetScratch::kTriangles) {
    if (!scratch) throw std::bad_alloc();
    return SplitSmallSubset(kept, subset, rays, *scratch);
  }
  try {
    if (scratch) return SplitByGrid(kept, subset, *scratch, tasks);
  } catch (const std::bad_alloc&) {
  }
  // To test every ray against every triangle of a large one would take as good as for ever.
  return SplitInPlace(kept, subset);
}

/// Something to do while another thread splits a subset: splits one that stands beside it in its
/// node, where rays are likely to come next. False if there is none.
inline bool SplitNeighbour(KeptPartition& kept, const Subset& subset, SubsetScratch& scratch) {
  if (subset.parent == Subset::kNowhere) return false;
  const WideNode& node = kept.node(subset.parent / WideNode::kWidth);
  for (size_t i = 0; i < node.count; ++i) {
    const ChildWord child = node.Child(i);
    if (!child.IsSubset()) continue;
    Subset& other = kept.subset(child.number());
    uint32_t unsplit = Subset::kUnsplit;
    if (other.count > SubsetScratch::kTriangles ||
        !other.root.compare_exchange_strong(unsplit, Subset::kBeingSplit)) {
      continue;
    }
    const OrdinaryArithmetic ordinary;
    Publish(kept, other, SplitSmallSubset(kept, other, 0, scratch));
    return true;
  }
  return false;
}

/// The root of a subset, which is split now for `rays` rays if it is not yet, or if its triangles
/// have moved too far; Subset::kNoRoom if the budget does not allow it. Threads that come while
/// another one splits it split others beside it, or wait. `tasks` as for SplitByGrid.
///
/// Where there is no memory to split a small subset, `otherwise()` is called while nobody else can
/// split it, and nothing is returned.
template <class Otherwise>
inline std::optional<uint32_t> RootOf(KeptPartition& kept, uint32_t number, size_t rays,
                                      SubsetScratch* scratch, TaskPool* tasks,
                                      const Otherwise& otherwise) {
  Subset& subset = kept.subset(number);
  uint32_t before;
  for (;;) {
    const uint32_t root = subset.root.load(std::memory_order_acquire);
    if (HWY_LIKELY(Subset::HasNodes(root) || root == Subset::kNoRoom)) return root;
    before = root;
    if (root != Subset::kBeingSplit &&
        subset.root.compare_exchange_strong(before, Subset::kBeingSplit)) {
      break;
    }
    if (!scratch || !SplitNeighbour(kept, subset, *scratch)) {
      subset.root.wait(Subset::kBeingSplit);
    }
  }
  try {
    if (Subset::IsStale(before) && !scratch) throw std::bad_alloc();
    const OrdinaryArithmetic ordinary;
    const uint32_t root = Subset::IsStale(before)
                              ? SplitAnew(kept, subset, Subset::NodeOf(before), rays, *scratch)
                              : SplitSubset(kept, subset, rays, scratch, tasks);
    Publish(kept, subset, root);
    return root;
  } catch (const std::bad_alloc&) {
  }
  try {
    otherwise();
  } catch (...) {
    Publish(kept, subset, before);
    throw;
  }
  Publish(kept, subset, before);  // there may be memory the next time
  return std::nullopt;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_BY_GRID_INL_H_
