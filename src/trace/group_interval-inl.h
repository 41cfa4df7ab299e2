// Bounds of the rays of a group, by which children are left out for all of them at once.
//
// Reshetov, Soupikov, Hurley, "Multi-level ray tracing algorithm", SIGGRAPH 2005.

#if defined(DACRT_TRACE_GROUP_INTERVAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_INTERVAL_INL_H_
#undef DACRT_TRACE_GROUP_INTERVAL_INL_H_
#else
#define DACRT_TRACE_GROUP_INTERVAL_INL_H_
#endif

#include "geometry/four_by_four-inl.h"
#include "geometry/wide_node-inl.h"
#include "trace/group_lanes-inl.h"
#include "trace/policy.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The least and the largest value of some lanes of a group, for four rows of values at a time:
/// what one row costs is mostly waiting.
struct FourBounds {
  HWY_ALIGN float low[4], high[4];

  template <size_t kMost>
  HWY_INLINE FourBounds(const GroupLanes<kMost>& group, LaneMask lanes,
                        const float* const (&rows)[4]) {
    // Of one vector all lanes cost what some do.
    if (GroupLanes<kMost>::kMostParts > 1 && group.AreAll(lanes)) {
      Bound<true>(group, lanes, rows);
    } else {
      Bound<false>(group, lanes, rows);
    }
  }

 private:
  /// With kAll, the lanes are all.
  template <bool kAll, size_t kMost>
  HWY_INLINE void Bound(const GroupLanes<kMost>& group, LaneMask lanes,
                        const float* const (&rows)[4]) {
    const size_t some_lane = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
    const auto load = [&](const float* row, size_t part) HWY_ATTR {
      const size_t first = part * Lanes();
      const V values = hn::Load(kFloat, row + first);
      if constexpr (kAll) return values;
      return hn::IfThenElse(MaskOf(lanes >> first), values, hn::Set(kFloat, row[some_lane]));
    };
    V least[4], largest[4];
    for (int row = 0; row < 4; ++row) least[row] = largest[row] = load(rows[row], 0);
    for (size_t part = 1; part < group.parts(); ++part) {
      for (int row = 0; row < 4; ++row) {
        const V values = load(rows[row], part);
        least[row] = hn::Min(least[row], values);
        largest[row] = hn::Max(largest[row], values);
      }
    }
    StoreRows(least, [](auto a, auto b) HWY_ATTR { return hn::Min(a, b); }, low);
    StoreRows(largest, [](auto a, auto b) HWY_ATTR { return hn::Max(a, b); }, high);
  }

  /// What `of_two` makes of all lanes of each row.
  template <class OfTwo>
  static HWY_INLINE void StoreRows(const V (&rows)[4], [[maybe_unused]] const OfTwo& of_two,
                                   float* to) {
#if HWY_TARGET == HWY_SCALAR
    for (size_t row = 0; row < 4; ++row) to[row] = hn::GetLane(rows[row]);
#else
    FourByFour<D> lanes{{rows[0], rows[1], rows[2], rows[3]}};
    lanes.Transpose();
    const auto quads = of_two(of_two(lanes.v[0], lanes.v[1]), of_two(lanes.v[2], lanes.v[3]));
    hn::Store(OfQuads(kFloat, quads, of_two), kCornerTag, to);
#endif
  }

#if HWY_TARGET != HWY_SCALAR
  /// What it makes of every fourth lane.
  template <class Tag, class OfTwo>
  static HWY_INLINE auto OfQuads(Tag, hn::Vec<Tag> quads, const OfTwo& of_two) {
    if constexpr (hn::MaxLanes(Tag()) == 4) {
      return quads;
    } else {
      const hn::Half<Tag> half;
      return OfQuads(half, of_two(hn::LowerHalf(half, quads), hn::UpperHalf(half, quads)), of_two);
    }
  }
#endif
};

/// Bounds of a group's rays, for the slab test of all of them at once: on each axis the least and
/// the largest origin and length of the reciprocal, with their sign.
struct GroupInterval {
  EightPart org_for_near[3], org_for_far[3];  ///< of which the distance is least, and largest
  EightPart least[3], most[3];                ///< of the reciprocals, signed
  EightPart start;
  bool is_tight;  ///< hardly wider than the rays
  float apart;    ///< how far the origins differ, on the axis on which they do most
  float spread;   ///< the same of the directions
  float length;   ///< of directions, the largest component

  /// Of the rays of some lanes.
  template <size_t kMost>
  HWY_INLINE GroupInterval(const GroupLanes<kMost>& group, LaneMask lanes, uint32_t octant) {
    const auto& [org_x, org_y, org_z] = group.org;
    const auto& [slope_x, slope_y, slope_z] = group.reciprocal;
    const FourBounds points(group, lanes, {org_x, org_y, org_z, group.start});
    const FourBounds slopes(group, lanes, {slope_x, slope_y, slope_z, slope_z});
    HWY_ALIGN float sizes[4], spreads[4], lengths[4], looseness[4];
    for (size_t i = 0; i < 4; i += hn::MaxLanes(kCornerTag)) {
      const auto low = hn::Load(kCornerTag, slopes.low + i);
      const auto high = hn::Load(kCornerTag, slopes.high + i);
      const auto largest = hn::Max(hn::Neg(low), high), smallest = hn::Max(low, hn::Neg(high));
      const auto one = hn::Set(kCornerTag, 1.0f), longest = hn::Div(one, smallest);
      hn::Store(longest, kCornerTag, lengths + i);
      hn::Store(hn::Sub(longest, hn::Div(one, largest)), kCornerTag, spreads + i);
      hn::Store(hn::NegMulAdd(hn::Set(kCornerTag, policy::kTightReciprocals), smallest, largest),
                kCornerTag, looseness + i);
      hn::Store(hn::Sub(hn::Load(kCornerTag, points.high + i), hn::Load(kCornerTag, points.low + i)),
                kCornerTag, sizes + i);
    }
    const auto largest_of = [](const float* values)
        { return HWY_MAX(HWY_MAX(values[0], values[1]), values[2]); };
    apart = largest_of(sizes);
    spread = largest_of(spreads);
    length = largest_of(lengths);
    is_tight = largest_of(looseness) <= 0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = (octant >> axis) & 1;
      org_for_near[axis] = hn::Set(kEightTag, (negative ? points.low : points.high)[axis]);
      org_for_far[axis] = hn::Set(kEightTag, (negative ? points.high : points.low)[axis]);
      least[axis] = hn::Set(kEightTag, slopes.low[axis]);
      most[axis] = hn::Set(kEightTag, slopes.high[axis]);
    }
    start = hn::Set(kEightTag, points.low[3]);
  }

  /// Whether the rays run close together in a scene of a certain extent.
  HWY_INLINE bool IsNarrow(float reach) const {
    return spread <= policy::kGroupDirections * length && apart <= policy::kGroupOrigins * reach;
  }

  /// The children that a ray of the group may enter, a bit each; entry[i] is not above where any of
  /// them does.
  HWY_INLINE uint32_t EnterChildren(const ChildPlanes& planes, float tfar, float* entry) const {
    uint32_t entered = 0;
    for (size_t part = 0; part < kParts; ++part) {
      EightPart first;
      entered |= EnterPart(planes.near[part], planes.far[part], tfar, first) << (part * kPartLanes);
      hn::Store(first, kEightTag, entry + part * kPartLanes);
    }
    return entered;
  }

  /// Those of the children, entered at `entry`, that are as wide as the group is there: of them the
  /// interval alone tells nearly as much as all rays would. Of smaller ones, as where triangles are
  /// no larger than pixels, it takes in all that stand in the way between the rays.
  HWY_INLINE uint32_t WideChildren(const ChildPlanes& planes, const float* entry) const {
    if (!is_tight) return 0;
    uint32_t wide = 0;
    for (size_t part = 0; part < kParts; ++part) {
      EightPart size = hn::Zero(kEightTag);
      for (int axis = 0; axis < 3; ++axis) {
        size = hn::Max(size, hn::Abs(hn::Sub(planes.far[part][axis], planes.near[part][axis])));
      }
      const EightPart width = hn::MulAdd(hn::Load(kEightTag, entry + part * kPartLanes),
                                         hn::Set(kEightTag, spread), hn::Set(kEightTag, apart));
      wide |= static_cast<uint32_t>(Bits(kEightTag, hn::Ge(size, width))) << (part * kPartLanes);
    }
    return wide;
  }

  /// The same as EnterChildren for boxes in the lanes of a vector. `offsets` are those of the
  /// octant.
  HWY_INLINE uint32_t EnterBoxes(const WideBoxOf<EightPart>& boxes, const PlaneOffsets& offsets,
                                 float tfar) const {
    EightPart near[3], far[3], first;
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = offsets.near[axis] > offsets.far[axis];
      near[axis] = negative ? boxes.upper[axis] : boxes.lower[axis];
      far[axis] = negative ? boxes.lower[axis] : boxes.upper[axis];
    }
    return EnterPart(near, far, tfar, first);
  }

 private:
  HWY_INLINE uint32_t EnterPart(const EightPart* near_planes, const EightPart* far_planes,
                                float tfar, EightPart& entry) const {
    EightPart near = start, far = hn::Set(kEightTag, tfar);
    for (int axis = 0; axis < 3; ++axis) {
      const EightPart to_near = hn::Sub(near_planes[axis], org_for_near[axis]);
      const EightPart to_far = hn::Sub(far_planes[axis], org_for_far[axis]);
      near = hn::Max(near,
                     hn::Mul(hn::Min(hn::Mul(to_near, least[axis]), hn::Mul(to_near, most[axis])),
                             hn::Set(kEightTag, 1.0f - 2 * kDistanceSlack)));
      far = hn::Min(far, hn::Mul(hn::Max(hn::Mul(to_far, least[axis]), hn::Mul(to_far, most[axis])),
                                 hn::Set(kEightTag, 1.0f + 2 * kDistanceSlack)));
    }
    entry = near;
    return static_cast<uint32_t>(Bits(kEightTag, hn::Le(near, far)));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_INTERVAL_INL_H_
