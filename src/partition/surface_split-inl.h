// A split by the surface area heuristic, for partitions that are kept: batches yet unknown will use
// it, so no sample rays have a say in it.
// Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

#if defined(DACRT_PARTITION_SURFACE_SPLIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SURFACE_SPLIT_INL_H_
#undef DACRT_PARTITION_SURFACE_SPLIT_INL_H_
#else
#define DACRT_PARTITION_SURFACE_SPLIT_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "partition/partition_triangles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What is split: references to triangles, or to cells (grid-inl.h) that hold several.
struct Triangles {
  static HWY_INLINE size_t Weight(const TriangleRef&) { return 1; }
};
struct Cells {
  /// A cell's number of triangles stands in the place of the mesh.
  static HWY_INLINE size_t Weight(const TriangleRef& cell) { return cell.mesh; }
};

/// A range of references, and how many triangles they hold.
struct WeighedRange {
  TriangleRange range;
  size_t weight;
};

struct WeighedChildren {
  WeighedRange left;
  WeighedRange right;
};

/// Bins for `count` references: fewer for fewer, because most of the work of a partition is in its
/// smallest subproblems.
inline uint32_t SurfaceBins(size_t count) {
  return static_cast<uint32_t>(std::min(SubsetScratch::kBins, 4 + count / 16));
}

/// Two halves by count.
template <class Items>
inline WeighedChildren HalveWeighed(const TriangleRef* refs, const WeighedRange& parent) {
  const Children children = HalveTriangles(refs, parent.range);
  size_t left_weight = 0;
  for (size_t i = children.left.begin; i < children.left.end; ++i) {
    left_weight += Items::Weight(refs[i]);
  }
  return {{children.left, left_weight}, {children.right, parent.weight - left_weight}};
}

/// The best split of a range of at least two references by the surfaces of its sides, with the
/// references moved; two halves by count if no split by bins has something on both sides.
template <class Items>
inline WeighedChildren SplitBySurface(TriangleRef* refs, const WeighedRange& parent,
                                      SubsetScratch& scratch) {
  const TriangleRange& range = parent.range;
  const uint32_t bins = SurfaceBins(range.count());
  const BinMap map(range.centers, bins);
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(scratch.bins[axis], bins, Bin{Box::Empty(), 0});
  }
  for (size_t i = range.begin; i < range.end; ++i) {
    const Corner lower = Corner::Load(refs[i].lower), upper = Corner::Load(refs[i].upper);
    HWY_ALIGN int32_t number[4];
    map.Map(TwiceCenter(lower, upper), number);
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = scratch.bins[axis][number[axis]];
      ExtendBox(bin.bounds, lower, upper);
      bin.count += Items::Weight(refs[i]);
    }
  }

  const auto extend = [](CornerBounds& bounds, const Bin& bin) HWY_ATTR {
    bounds.Extend(Corner::Load(bin.bounds.lower), Corner::Load(bin.bounds.upper));
  };
  constexpr float kNever = std::numeric_limits<float>::infinity();
  float best_cost = kNever;
  Split best{map, 0, 0, 0, Box::Empty(), Box::Empty()};
  for (int axis = 0; axis < 3; ++axis) {
    if (!map.IsUseful(axis)) continue;
    const Bin* const bin = scratch.bins[axis];
    float right_cost[SubsetScratch::kBins];
    Box right_box[SubsetScratch::kBins];
    CornerBounds right;
    size_t weight = 0;
    for (uint32_t k = bins - 1; k > 0; --k) {
      extend(right, bin[k]);
      weight += bin[k].count;
      right_box[k] = right.Get();
      right_cost[k] = weight == 0 ? kNever : right_box[k].HalfArea() * static_cast<float>(weight);
    }
    CornerBounds left;
    weight = 0;
    for (uint32_t k = 0; k + 1 < bins; ++k) {
      extend(left, bin[k]);
      weight += bin[k].count;
      if (weight == 0) continue;
      const Box left_box = left.Get();
      const float cost = left_box.HalfArea() * static_cast<float>(weight) + right_cost[k + 1];
      if (cost >= best_cost) continue;
      best_cost = cost;
      best = Split{map, axis, k, weight, left_box, right_box[k + 1]};
    }
  }
  if (best_cost == kNever) return HalveWeighed<Items>(refs, parent);
  const Children children = PartitionTriangles(refs, range, best);
  return {{children.left, best.left_count}, {children.right, parent.weight - best.left_count}};
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SURFACE_SPLIT_INL_H_
