// An order along which leaves have less surface than along a curve alone: runs of it, each in the
// order in which space is split by surface until a leaf holds what is left, and that from one side
// to the other. What the runs are later cut into (pack_along_curve-inl.h) need not be those halves.

#if defined(DACRT_PARTITION_SORT_BY_SURFACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
#undef DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
#else
#define DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
#endif

#include "partition/partition_triangles-inl.h"
#include "partition/surface_split-inl.h"
#include "partition/weighed_range-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Sorts the first `count` of scratch.refs, which stand along a curve. Longer runs gain nothing
/// more: where 256 became 2,048, rays visited as many nodes and leaves, and the first ones took a
/// tenth longer; with 64 half of the gain in leaves was left.
template <class Kind>
inline void SortBySurface(const Kind& kind, size_t count, SubsetScratch& scratch) {
  constexpr size_t kRun = 256;
  TriangleRef* const refs = scratch.refs;
  for (size_t begin = 0; begin < count; begin += kRun) {
    const size_t end = HWY_MIN(begin + kRun, count);
    size_t weight = 0;
    for (size_t i = begin; i < end; ++i) weight += kind.Weight(refs[i]);
    OpenRanges open({{MeasureTriangles(refs, begin, end), weight}, 0});
    while (!open.is_empty()) {
      const WeighedRange next = open.Take().range;
      if (next.weight <= kLeafLanes || next.range.count() == 1) continue;
      const WeighedChildren halves = SplitRange(kind, refs, next, scratch);
      open.Add({halves.left, 0}, {halves.right, 0});
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SORT_BY_SURFACE_INL_H_
