// An order along which leaves have less surface than along a curve alone: runs of it, each in the
// order in which space is split by surface until a leaf holds what is left, and that from one side
// to the other. What the runs are later cut into (pack_along_curve-inl.h) need not be those halves.

#if defined(DACRT_PARTITION_SORT_BY_SURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
#undef DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
#else
#define DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "geometry/sort_eight-inl.h"
#include "partition/partition_triangles-inl.h"
#include "partition/surface_split-inl.h"
#include "partition/weighed_range-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Sorts at most eight references by their centres on the axis on which these differ most.
inline void SortOnAxis(const TriangleRange& range, SubsetScratch& scratch) {
  constexpr float kLast = std::numeric_limits<float>::infinity();
  const Box& centers = range.centers;
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (centers.upper[i] - centers.lower[i] > centers.upper[axis] - centers.lower[axis]) axis = i;
  }
  TriangleRef* const refs = scratch.refs + range.begin;
  HWY_ALIGN float places[kParts * kPartLanes];
  std::fill_n(places, kParts * kPartLanes, kLast);
  for (size_t i = 0; i < range.count(); ++i) {
    places[i] = refs[i].lower[axis] + refs[i].upper[axis];
  }
  EightPart values[kParts];
  for (size_t part = 0; part < kParts; ++part) {
    values[part] = hn::Load(kEightTag, places + part * kPartLanes);
  }
  uint8_t order[kParts * kPartLanes];
  SortEight(values, order);
  size_t count = 0;
  for (const uint8_t i : order) {
    if (i < range.count()) scratch.spare[count++] = refs[i];
  }
  std::copy_n(scratch.spare, count, refs);
}

/// Sorts the first `count` of scratch.refs, which stand along a curve. Longer runs gain nothing
/// more: where 256 became 2,048, rays visited as many nodes and leaves, and the first ones took a
/// tenth longer; with 64 half of the gain in leaves was left.
template <class Kind>
inline void SortBySurface(const Kind& kind, size_t count, SubsetScratch& scratch) {
  constexpr size_t kRun = 256;
  TriangleRef* const refs = scratch.refs;
  // Of two sides the smaller one is next.
  WeighedRange open[8 * sizeof(size_t)];
  for (size_t begin = 0; begin < count; begin += kRun) {
    const size_t end = HWY_MIN(begin + kRun, count);
    size_t weight = 0;
    for (size_t i = begin; i < end; ++i) weight += kind.Weight(refs[i]);
    size_t open_count = 0;
    open[open_count++] = {MeasureTriangles(refs, begin, end), weight};
    while (open_count > 0) {
      const WeighedRange next = open[--open_count];
      if (next.range.count() == 1) continue;
      if (next.weight <= kLeafLanes) {
        SortOnAxis(next.range, scratch);
        continue;
      }
      const WeighedChildren halves = SplitRange(kind, refs, next, scratch);
      const bool left_is_larger = halves.left.range.count() > halves.right.range.count();
      open[open_count++] = left_is_larger ? halves.left : halves.right;
      open[open_count++] = left_is_larger ? halves.right : halves.left;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
