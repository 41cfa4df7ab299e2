// Whether a triangle that a ray meets counts: only if the ray enters the triangle's own box (see
// geometry/triangle_test-inl.h), which nearly all do, and before they meet the triangle.
//
// Where a ray does so with the nearest of the triangles that it meets, by their distances alone,
// that one is the hit: its key is its distance, and no key is less than the distance of its
// triangle. So one box is asked, and only if the ray is not in it so early those of all triangles.
//
// By the same reason the box may be asked last, when all leaves have been tested, of the one
// triangle that is left: whatever counts and has no greater key is entered before that key, so it
// was met on the way, and would have been taken, unless its distance or its name had come later.
// Only if the ray is not in the box so early has all been in vain, and the ray begins anew
// (trace/trace_view-inl.h). 64K diffuse rays, where it is asked at once and last (Zen 1, AVX2): the
// kitchen 328 and 290 ns a ray, Sponza 697 and 624; single rays, where all boxes are asked and one:
// 321 and 280, 643 and 587.

#if defined(DACRT_LEAF_OWN_BOX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_OWN_BOX_INL_H_
#undef DACRT_LEAF_OWN_BOX_INL_H_
#else
#define DACRT_LEAF_OWN_BOX_INL_H_
#endif

#include "geometry/lone_box-inl.h"
#include "leaf/cross_facets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Keeps of the triangles that a ray meets those whose own boxes it enters. Returns their keys.
template <class Ray, class Corners>
HWY_INLINE EightPart KeepInOwnBoxes(const Ray& ray, const Corners& corners,
                                    FacetCrossing& crossing) {
  // Axis by axis, for want of registers.
  const auto interval = IntersectSlabs([&](int axis) HWY_ATTR {
    const PlanesOnAxis own = corners.OwnPlanes(axis);
    return SlabsOf<EightPart>::Of(own.lower, own.upper, ray.org(axis), ray.reciprocal(axis));
  });
  crossing.lanes &= Bits(kEightTag, Enters(interval, ray.tnear(), ray.tfar()));
  return hn::Max(crossing.t, interval.entry);
}

/// Corners of triangles of which many rays may ask the own boxes: what is made of them for the
/// first one is kept for the others.
class CornersAndBoxes {
 public:
  HWY_INLINE explicit CornersAndBoxes(const CornerLanes& corners) : corners_(corners) {}

  HWY_INLINE CornersOnAxis OnAxis(int axis) const { return corners_.OnAxis(axis); }
  HWY_INLINE PlanesOnAxis OwnPlanes(int axis) const {
    // Those of one triangle cost no more than to keep them.
    if constexpr (kPartLanes == 1) return corners_.OwnPlanes(axis);
    if (HWY_UNLIKELY(!has_planes_)) MakePlanes();
    return {hn::Load(kEightTag, lower_[axis]), hn::Load(kEightTag, upper_[axis])};
  }

 private:
  HWY_INLINE void MakePlanes() const {
    for (int axis = 0; axis < 3; ++axis) {
      const PlanesOnAxis own = corners_.OwnPlanes(axis);
      hn::Store(own.lower, kEightTag, lower_[axis]);
      hn::Store(own.upper, kEightTag, upper_[axis]);
    }
    has_planes_ = true;
  }

  const CornerLanes& corners_;
  mutable bool has_planes_ = false;
  HWY_ALIGN mutable float lower_[3][kPartLanes], upper_[3][kPartLanes];
};

#if HWY_TARGET != HWY_SCALAR

template <class Corners>
HWY_INLINE LoneBox OwnBoxOf(const Corners&, const LeafBlock& block, size_t block_lane) {
  const uint8_t* const indices = block.indices() + block_lane;
  const float* const vertices = block.vertex_data();
  const CornerPart v0 = LoadAcross(vertices + indices[0], block.vertices);
  const CornerPart v1 = LoadAcross(vertices + indices[kLeafLanes], block.vertices);
  const CornerPart v2 = LoadAcross(vertices + indices[2 * kLeafLanes], block.vertices);
  return {OwnLower(v0, v1, v2), OwnUpper(v0, v1, v2)};
}
HWY_INLINE LoneBox OwnBoxOf(const LeafCorners<CornerLayout::kPrepared>&, const LeafBlock& block,
                            size_t block_lane) {
  const PreparedFacets& facets = block.prepared();
  return {LoadAcross(&facets.lower[0][block_lane], kLeafLanes),
          LoadAcross(&facets.upper[0][block_lane], kLeafLanes)};
}

/// Whether a ray enters the own box of a triangle of a block before `limit`. `corners` are those of
/// a part of the block, which does not move.
template <class Ray, class Corners>
HWY_INLINE bool EntersOwnBox(const Ray& ray, const Corners& corners, const LeafBlock& block,
                             size_t block_lane, float limit) {
  return Enters(ray.line(), OwnBoxOf(corners, block, block_lane), limit);
}

#else

/// One box costs as much as all that stand in a vector.
template <class Ray, class Corners>
HWY_INLINE bool EntersOwnBox(const Ray&, const Corners&, const LeafBlock&, size_t, float) {
  return false;
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_OWN_BOX_INL_H_
