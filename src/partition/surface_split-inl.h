// A split by the surface area heuristic, for partitions that are kept: batches yet unknown will use
// it, so no sample rays have a say in it, and only the best candidate is known in the end; those of
// paper/binning-inl.h are all kept for sample rays to choose from.
// Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

#if defined(DACRT_PARTITION_SURFACE_SPLIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SURFACE_SPLIT_INL_H_
#undef DACRT_PARTITION_SURFACE_SPLIT_INL_H_
#else
#define DACRT_PARTITION_SURFACE_SPLIT_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "partition/weighed_range-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Bins for `count` references: fewer for fewer, because most of the work of a partition is in its
/// smallest subproblems.
inline uint32_t SurfaceBins(size_t count) {
  return static_cast<uint32_t>(std::min(SubsetScratch::kBins, 4 + count / 16));
}

/// Two halves by count.
template <class Kind>
inline WeighedChildren HalveWeighed(const Kind& kind, const TriangleRef* refs,
                                    const WeighedRange& parent) {
  const Children children = HalveTriangles(refs, parent.range);
  size_t left_weight = 0;
  for (size_t i = children.left.begin; i < children.left.end; ++i) {
    left_weight += kind.Weight(refs[i]);
  }
  return {{children.left, left_weight}, {children.right, parent.weight - left_weight}};
}

/// Moves the references of the left side before those of the right. Sides come in no order that a
/// processor could predict, so each reference is written to both, and one place moves on.
inline Children PartitionWithSpare(TriangleRef* refs, const TriangleRange& range,
                                   const Split& split, TriangleRef* spare) {
  // A centre outside of a side's box is put infinitely far away, where it leaves the box as it is.
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  static constexpr float kLeast[2] = {kInfinity, -kInfinity};
  Extent left_centers = Extent::Empty(), right_centers = Extent::Empty();
  size_t left = range.begin, right = 0;
  for (size_t i = range.begin; i < range.end; ++i) {
    const Corner lower = Corner::Load(refs[i].lower), upper = Corner::Load(refs[i].upper);
    const int32_t bin =
        split.map.MapOnAxis(split.axis, refs[i].lower[split.axis] + refs[i].upper[split.axis]);
    const size_t is_left = bin <= static_cast<int32_t>(split.last_left_bin);
    const Extent center = Extent::Of(refs[i]).TwiceCenter();
    left_centers.Join(center.NotBelow(kLeast[is_left]));
    right_centers.Join(center.NotBelow(kLeast[1 - is_left]));
    lower.Store(refs[left].lower);
    upper.Store(refs[left].upper);
    lower.Store(spare[right].lower);
    upper.Store(spare[right].upper);
    left += is_left;
    right += 1 - is_left;
  }
  std::copy_n(spare, right, refs + left);
  return {{range.begin, left, split.left_box, left_centers.Get()},
          {left, range.end, split.right_box, right_centers.Get()}};
}

/// The best split of a range of at least two references by the surfaces of its sides, with the
/// references moved; two halves by count if no split by bins has something on both sides.
template <class Kind>
inline WeighedChildren SplitRange(const Kind& kind, TriangleRef* refs, const WeighedRange& parent,
                                  SubsetScratch& scratch) {
  const TriangleRange& range = parent.range;
  const uint32_t bins = SurfaceBins(range.count());
  const BinMap map(range.centers, bins);
  Extent::Floats extents[3][SubsetScratch::kBins];
  uint32_t weights[3][SubsetScratch::kBins];
  for (int axis = 0; axis < 3; ++axis) {
    for (uint32_t k = 0; k < bins; ++k) {
      Extent::Empty().Store(extents[axis][k]);
      weights[axis][k] = 0;
    }
  }
  for (size_t i = range.begin; i < range.end; ++i) {
    HWY_ALIGN int32_t number[4];
    map.Map(TwiceCenter(Corner::Load(refs[i].lower), Corner::Load(refs[i].upper)), number);
    const Extent extent = Extent::Of(refs[i]);
    for (int axis = 0; axis < 3; ++axis) {
      Extent::Floats& bin = extents[axis][number[axis]];
      Extent all = Extent::Load(bin);
      all.Join(extent);
      all.Store(bin);
      weights[axis][number[axis]] += static_cast<uint32_t>(kind.Weight(refs[i]));
    }
  }

  constexpr float kNever = std::numeric_limits<float>::infinity();
  const float scale = range.bounds.SurfaceScale();
  const auto cost_of = [&](const Extent& side, size_t weight)
                           HWY_ATTR { return side.HalfArea() * scale * LeafTests(weight); };
  float best_cost = kNever;
  int best_axis = 0;
  uint32_t best_bin = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!map.IsUseful(axis)) continue;
    float right_cost[SubsetScratch::kBins];
    Extent side = Extent::Empty();
    size_t weight = 0;
    for (uint32_t k = bins - 1; k > 0; --k) {
      side.Join(Extent::Load(extents[axis][k]));
      weight += weights[axis][k];
      right_cost[k] = weight == 0 ? kNever : cost_of(side, weight);
    }
    side = Extent::Empty();
    weight = 0;
    for (uint32_t k = 0; k + 1 < bins; ++k) {
      side.Join(Extent::Load(extents[axis][k]));
      weight += weights[axis][k];
      if (weight == 0) continue;
      const float cost = cost_of(side, weight) + right_cost[k + 1];
      if (cost >= best_cost) continue;
      best_cost = cost;
      best_axis = axis;
      best_bin = k;
    }
  }
  if (best_cost == kNever) return HalveWeighed(kind, refs, parent);
  Extent left = Extent::Empty(), right = Extent::Empty();
  size_t left_weight = 0;
  for (uint32_t k = 0; k < bins; ++k) {
    (k <= best_bin ? left : right).Join(Extent::Load(extents[best_axis][k]));
    if (k <= best_bin) left_weight += weights[best_axis][k];
  }
  const Split best{map, best_axis, best_bin, left_weight, left.Get(), right.Get()};
  const Children children = range.count() <= SubsetScratch::kTriangles
                                ? PartitionWithSpare(refs, range, best, scratch.spare)
                                : PartitionTriangles(refs, range, best);
  return {{children.left, left_weight}, {children.right, parent.weight - left_weight}};
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SURFACE_SPLIT_INL_H_
