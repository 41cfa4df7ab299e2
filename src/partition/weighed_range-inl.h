// Ranges of references, and what they weigh.

#if defined(DACRT_PARTITION_WEIGHED_RANGE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_WEIGHED_RANGE_INL_H_
#undef DACRT_PARTITION_WEIGHED_RANGE_INL_H_
#else
#define DACRT_PARTITION_WEIGHED_RANGE_INL_H_
#endif

#include "geometry/extent-inl.h"
#include "leaf/leaf_block.h"
#include "partition/partition_triangles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What is split: references to triangles, to items of several shapes, or to cells (grid.h) that
/// hold several triangles.
struct Triangles {
  HWY_INLINE size_t Weight(const TriangleRef&) const { return 1; }
};
struct Items {
  HWY_INLINE size_t Weight(const TriangleRef& item) const {
    return geometries.LanesOf(item.geometry);
  }
  const GeometryTable& geometries;
};
struct Cells {
  HWY_INLINE size_t Weight(const TriangleRef& cell) const { return cell.triangle_count; }
};

/// What testing a ray against so many triangles costs: a leaf's are tested side by side.
HWY_INLINE float LeafTests(size_t weight) {
  const size_t tests = (weight + kLeafLanes - 1) / kLeafLanes;
  return static_cast<float>(tests);
}

/// A range of references, and how many lanes of leaves they fill; of cells, how many triangles they
/// hold.
struct WeighedRange {
  TriangleRange range;
  size_t weight;
};

struct WeighedChildren {
  WeighedRange left;
  WeighedRange right;
};

/// A range that may be split, and its number, if it has one.
struct OpenRange {
  WeighedRange range;
  uint32_t number;
};

/// Those that are left. Of two sides the smaller one is next: so half as many references are left
/// with each place.
class OpenRanges {
 public:
  explicit OpenRanges(const OpenRange& first) { open_[count_++] = first; }

  bool is_empty() const { return count_ == 0; }
  HWY_INLINE OpenRange Take() { return open_[--count_]; }

  HWY_INLINE void Add(const OpenRange& left, const OpenRange& right) {
    const bool left_is_larger = left.range.range.count() > right.range.range.count();
    open_[count_++] = left_is_larger ? left : right;
    open_[count_++] = left_is_larger ? right : left;
  }

 private:
  OpenRange open_[8 * sizeof(size_t)];
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_WEIGHED_RANGE_INL_H_
