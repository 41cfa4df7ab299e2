// What one ray has found in a part of a leaf, to be looked at triangle by triangle.

#if defined(DACRT_LEAF_FOUND_IN_PART_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_FOUND_IN_PART_INL_H_
#undef DACRT_LEAF_FOUND_IN_PART_INL_H_
#else
#define DACRT_LEAF_FOUND_IN_PART_INL_H_
#endif

#include "leaf/cross_facets-inl.h"
#include "leaf/finish_hit-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Of some lanes, of which there is one, that with the least distance.
HWY_INLINE size_t NearestLane(uint64_t lanes, const float* distances) {
  size_t nearest = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
  ForEachLane(lanes & (lanes - 1), [&](size_t lane) {
    if (distances[lane] < distances[nearest]) nearest = lane;
  });
  return nearest;
}

struct FoundInPart {
  HWY_ALIGN float t[kPartLanes], u[kPartLanes], v[kPartLanes];  ///< u and v times divisor
  HWY_ALIGN float divisor[kPartLanes];
  HWY_ALIGN float ng[3][kPartLanes];

  FoundInPart() {}  // nothing is cleared

  /// `normals` are those of what is crossed.
  HWY_INLINE void Keep(const FacetCrossing& crossing, const EightPart* normals) {
    hn::Store(crossing.t, kEightTag, t);
    hn::Store(crossing.u, kEightTag, u);
    hn::Store(crossing.v, kEightTag, v);
    hn::Store(crossing.divisor, kEightTag, divisor);
    for (int axis = 0; axis < 3; ++axis) hn::Store(normals[axis], kEightTag, ng[axis]);
  }

  /// The hit on the triangle in a lane, which is that of an item with a name.
  HWY_INLINE FullHit Hit(size_t lane, const SceneParts& scene, uint32_t instance_id,
                         GeometryTable::Name name, bool is_second) const {
    const auto limited = [&](const float* values) {
      return HWY_MIN(values[lane] / divisor[lane], 1.0f);
    };
    return HitOf(scene, instance_id, name, is_second, t[lane], limited(u), limited(v), ng[0][lane],
                 ng[1][lane], ng[2][lane]);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_FOUND_IN_PART_INL_H_
