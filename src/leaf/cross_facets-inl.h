// Facets of a leaf in the lanes of a vector, and one ray against them.

#if defined(DACRT_LEAF_CROSS_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_CROSS_FACETS_INL_H_
#undef DACRT_LEAF_CROSS_FACETS_INL_H_
#else
#define DACRT_LEAF_CROSS_FACETS_INL_H_
#endif

#include "geometry/robust_test-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/leaf_block.h"
#include "rays/ray_record.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Corners 0, 1 and 2 of some triangles, a lane each.
struct CornerLanes {
  EightPart v0[3], v1[3], v2[3];
};

/// Some triangles of a leaf with what the tests want; `v1` and `v2` for the robust one, and for the
/// triangles' own boxes.
struct LeafTriangles {
  TestTrianglesOf<EightPart> test;
  EightPart v1[3], v2[3];

  HWY_INLINE explicit LeafTriangles(const CornerLanes& corners)
      : test(TrianglesOf(corners.v0, corners.v1, corners.v2)) {
    for (int axis = 0; axis < 3; ++axis) {
      v1[axis] = corners.v1[axis];
      v2[axis] = corners.v2[axis];
    }
  }
};

#if HWY_TARGET <= HWY_AVX2
/// Values of a table in memory, of up to 3 * kLeafLanes, picked by lanes of `indices`. Reads two
/// whole vectors from the table, or three where it is longer.
HWY_INLINE EightPart PickLanes(const float* table, hn::Vec<hn::RebindToSigned<EightTag>> indices,
                               size_t size) {
  const hn::RebindToSigned<EightTag> di;
  const EightPart low = hn::LoadU(kEightTag, table), high = hn::LoadU(kEightTag, table + 8);
#if HWY_TARGET <= HWY_AVX3
  EightPart picked{_mm256_permutex2var_ps(low.raw, indices.raw, high.raw)};
#else
  const auto lane = hn::IndicesFromVec(kEightTag, hn::And(indices, hn::Set(di, 7)));
  EightPart picked =
      hn::IfThenElse(hn::RebindMask(kEightTag, hn::Gt(indices, hn::Set(di, 7))),
                     hn::TableLookupLanes(high, lane), hn::TableLookupLanes(low, lane));
#endif
  if (HWY_UNLIKELY(size > 16)) {
    const auto rest = hn::IndicesFromVec(kEightTag, hn::And(indices, hn::Set(di, 7)));
    const EightPart last = hn::TableLookupLanes(hn::LoadU(kEightTag, table + 16), rest);
    picked =
        hn::IfThenElse(hn::RebindMask(kEightTag, hn::Gt(indices, hn::Set(di, 15))), last, picked);
  }
  return picked;
}
#endif

/// The corners of a part of a block's triangles, of moving ones at a time step. Lanes without one
/// hold a triangle of no area.
HWY_INLINE CornerLanes DecodeCorners(const LeafBlock& block, size_t part, size_t step = 0) {
  CornerLanes lanes;
  EightPart* const corners[3] = {lanes.v0, lanes.v1, lanes.v2};
  const size_t count = block.vertices;
  const float* const vertices = block.vertex_data() + 3 * step * count;
#if HWY_TARGET <= HWY_AVX2
  (void)part;
  const hn::RebindToSigned<EightTag> di;
  const hn::Rebind<uint8_t, EightTag> d8;
  for (size_t corner = 0; corner < 3; ++corner) {
    const auto indices = hn::PromoteTo(di, hn::LoadU(d8, block.indices() + corner * kLeafLanes));
    for (size_t axis = 0; axis < 3; ++axis) {
      corners[corner][axis] = PickLanes(vertices + axis * count, indices, count);
    }
  }
#else
  HWY_ALIGN float values[kPartLanes];
  for (size_t corner = 0; corner < 3; ++corner) {
    const uint8_t* const indices = block.indices() + corner * kLeafLanes + part * kPartLanes;
    for (size_t axis = 0; axis < 3; ++axis) {
      for (size_t i = 0; i < kPartLanes; ++i) values[i] = vertices[axis * count + indices[i]];
      corners[corner][axis] = hn::Load(kEightTag, values);
    }
  }
#endif
  return lanes;
}

/// Between two time steps, as Embree does it.
HWY_INLINE CornerLanes Interpolate(const CornerLanes& begin, const CornerLanes& end,
                                   float fraction) {
  CornerLanes lanes;
  const EightPart to_end = hn::Set(kEightTag, fraction);
  const EightPart to_begin = hn::Set(kEightTag, 1.0f - fraction);
  const auto between = [&](EightPart a, EightPart b)
                           HWY_ATTR { return hn::MulAdd(to_begin, a, hn::Mul(to_end, b)); };
  for (int axis = 0; axis < 3; ++axis) {
    lanes.v0[axis] = between(begin.v0[axis], end.v0[axis]);
    lanes.v1[axis] = between(begin.v1[axis], end.v1[axis]);
    lanes.v2[axis] = between(begin.v2[axis], end.v2[axis]);
  }
  return lanes;
}

/// Where one ray meets some triangles.
struct FacetCrossing {
  uint64_t lanes = 0;     ///< that it meets, a bit each; what follows means nothing in others
  uint64_t within_limit;  ///< and that pass Embree's test against tfar
  EightPart t;
  EightPart entry;  ///< into the triangle's own box
  EightPart u, v;   ///< times divisor
  EightPart divisor;
};

/// Lanes of those that meet whose triangle's own box the ray enters; `entry` is where.
HWY_INLINE uint64_t EnterOwnBoxes(const RayRecord& ray, const TestRaysOf<EightPart>& rays,
                                  const LeafTriangles& triangles, hn::Mask<EightTag> meet,
                                  EightPart& entry) {
  EightPart reciprocal[3];
  for (int axis = 0; axis < 3; ++axis) reciprocal[axis] = hn::Set(kEightTag, ray.reciprocal[axis]);
  const auto interval =
      IntersectBox(OwnBox(triangles.test.v0, triangles.v1, triangles.v2), rays.org, reciprocal);
  entry = interval.entry;
  return Bits(kEightTag, hn::And(meet, Enters(interval, rays.tnear, rays.tfar)));
}

template <bool kRobust>
HWY_INLINE FacetCrossing CrossFacets(const RayRecord& ray, const LeafTriangles& triangles) {
  TestRaysOf<EightPart> rays;
  for (int axis = 0; axis < 3; ++axis) {
    rays.org[axis] = hn::Set(kEightTag, ray.org[axis]);
    rays.dir[axis] = hn::Set(kEightTag, ray.dir[axis]);
  }
  rays.tnear = hn::Set(kEightTag, ray.tnear);
  rays.tfar = hn::Set(kEightTag, ray.tfar);
  FacetCrossing crossing;
  if constexpr (kRobust) {
    const auto terms = TestRobustly(rays, triangles.test, triangles.v1, triangles.v2);
    auto meet = terms.meet;
    if (HWY_LIKELY(hn::AllFalse(kEightTag, meet))) return crossing;
    crossing.t = hn::Div(Dot(triangles.test.ng, terms.v0), terms.den);
    meet = hn::And(meet, MeetsAtDistance(rays, crossing.t));
    if (hn::AllFalse(kEightTag, meet)) return crossing;
    crossing.lanes = EnterOwnBoxes(ray, rays, triangles, meet, crossing.entry);
    crossing.within_limit = crossing.lanes;
    crossing.u = terms.u;
    crossing.v = terms.v;
    crossing.divisor = terms.sum;
  } else {
    // Both before one branch, which is hard enough to foresee.
    const auto terms = EdgeTerms(rays.org, rays.dir, triangles.test);
    const EightPart t = DepthTerm(triangles.test, terms);
    const auto meet = hn::And(PassesInside(terms), MeetsInDepth(rays, t, terms.den));
    if (HWY_LIKELY(hn::AllFalse(kEightTag, meet))) return crossing;
    crossing.lanes = EnterOwnBoxes(ray, rays, triangles, meet, crossing.entry);
    crossing.within_limit = Bits(kEightTag, IsWithinLimit(rays, t, terms.den));
    crossing.t = hn::Div(t, terms.den);
    crossing.u = terms.u;
    crossing.v = terms.v;
    crossing.divisor = terms.den;
  }
  return crossing;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_CROSS_FACETS_INL_H_
