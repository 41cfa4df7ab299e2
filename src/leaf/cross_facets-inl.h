// Facets of a leaf in the lanes of a vector, and one ray against them.

#if defined(DACRT_LEAF_CROSS_FACETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_CROSS_FACETS_INL_H_
#undef DACRT_LEAF_CROSS_FACETS_INL_H_
#else
#define DACRT_LEAF_CROSS_FACETS_INL_H_
#endif

#include "geometry/lone_box-inl.h"
#include "geometry/robust_test-inl.h"
#include "geometry/wide_node-inl.h"
#include "leaf/leaf_block.h"
#include "rays/closeness.h"
#include "rays/ray_record.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Between which their own boxes lie, of some triangles, a lane each, on one axis.
struct PlanesOnAxis {
  EightPart lower, upper;
};

/// Corners 0, 1 and 2 of these.
struct CornersOnAxis {
  EightPart v0, v1, v2;

  HWY_INLINE PlanesOnAxis OwnPlanes() const { return {OwnLower(v0, v1, v2), OwnUpper(v0, v1, v2)}; }
};

/// The same on all axes.
struct CornerLanes {
  EightPart v0[3], v1[3], v2[3];

  HWY_INLINE void Set(int axis, const CornersOnAxis& corners) {
    v0[axis] = corners.v0;
    v1[axis] = corners.v1;
    v2[axis] = corners.v2;
  }
  HWY_INLINE CornersOnAxis OnAxis(int axis) const { return {v0[axis], v1[axis], v2[axis]}; }
  HWY_INLINE PlanesOnAxis OwnPlanes(int axis) const { return OnAxis(axis).OwnPlanes(); }
  HWY_INLINE TestTrianglesOf<EightPart> Triangles() const { return TrianglesOf(v0, v1, v2); }
};

/// How the corners of a block are found.
enum class CornerLayout {
  kPrepared,  ///< each has a place of its own, and so has what is made of them
  kByLane,    ///< each has a place of its own
  kFew,       ///< by indices into at most 16 vertices, which two vectors hold
  kMany,      ///< by indices
};

HWY_INLINE CornerLayout LayoutOf(const LeafBlock& block) {
  if (block.vertices <= 16) return CornerLayout::kFew;
  if (block.is_prepared) return CornerLayout::kPrepared;
  return block.vertices == LeafBlock::kByLane ? CornerLayout::kByLane : CornerLayout::kMany;
}

/// The corners of a part of a block's triangles, of moving ones at a time step. Lanes without one
/// hold a triangle of no area.
template <CornerLayout kLayout>
struct LeafCorners {
  const LeafBlock& block;
  size_t part;
  size_t step = 0;

  /// The same, to be read anew: otherwise the compiler keeps what it has read, for which there are
  /// not the registers.
  HWY_INLINE LeafCorners Again() const {
    const LeafBlock* same = &block;
    asm("" : "+r"(same));
    return {*same, part, step};
  }

  HWY_INLINE CornersOnAxis OnAxis(int axis) const {
    const size_t count = kIsByLane ? size_t{LeafBlock::kByLane} : block.vertices;
    const float* const vertices =
        block.vertex_data() + (3 * step + static_cast<size_t>(axis)) * count;
    return {Corner(0, vertices), Corner(1, vertices), Corner(2, vertices)};
  }

  HWY_INLINE CornerLanes All() const {
    CornerLanes corners;
    for (int axis = 0; axis < 3; ++axis) corners.Set(axis, OnAxis(axis));
    return corners;
  }

  HWY_INLINE TestTrianglesOf<EightPart> Triangles() const {
    if constexpr (kLayout != CornerLayout::kPrepared) return All().Triangles();
    const PreparedFacets& facets = block.prepared();
    TestTrianglesOf<EightPart> triangles;
    for (int axis = 0; axis < 3; ++axis) {
      triangles.v0[axis] = LoadPart(facets.v0[axis]);
      triangles.e1[axis] = LoadPart(facets.e1[axis]);
      triangles.e2[axis] = LoadPart(facets.e2[axis]);
      triangles.ng[axis] = LoadPart(facets.ng[axis]);
    }
    return triangles;
  }
  HWY_INLINE PlanesOnAxis OwnPlanes(int axis) const {
    if constexpr (kLayout != CornerLayout::kPrepared) return OnAxis(axis).OwnPlanes();
    const PreparedFacets& facets = block.prepared();
    return {LoadPart(facets.lower[axis]), LoadPart(facets.upper[axis])};
  }

 private:
  static constexpr bool kIsByLane =
      kLayout == CornerLayout::kPrepared || kLayout == CornerLayout::kByLane;

  HWY_INLINE EightPart LoadPart(const float* lanes) const {
    return hn::LoadU(kEightTag, lanes + part * kPartLanes);
  }

  /// `vertices` are the values of an axis.
  HWY_INLINE EightPart Corner(size_t corner, const float* vertices) const {
    const size_t first = corner * kLeafLanes + part * kPartLanes;
    if constexpr (kIsByLane) return hn::LoadU(kEightTag, vertices + first);
    const uint8_t* const indices = block.indices() + first;
#if HWY_TARGET <= HWY_AVX2
    const hn::RebindToSigned<EightTag> di;
    const auto lanes = hn::PromoteTo(di, hn::LoadU(hn::Rebind<uint8_t, EightTag>(), indices));
#if HWY_TARGET <= HWY_AVX3
    if constexpr (kLayout == CornerLayout::kMany) {
      return hn::GatherIndex(kEightTag, vertices, lanes);
    }
    const EightPart low = hn::LoadU(kEightTag, vertices), high = hn::LoadU(kEightTag, vertices + 8);
    return EightPart{_mm256_permutex2var_ps(low.raw, lanes.raw, high.raw)};
#else
    // Processors that have no more than AVX2 take long to gather.
    const auto lane = hn::IndicesFromVec(kEightTag, hn::And(lanes, hn::Set(di, 7)));
    const auto values_from = [&](size_t first) HWY_ATTR {
      return hn::TableLookupLanes(hn::LoadU(kEightTag, vertices + first), lane);
    };
    const auto are_beyond = [&](int32_t last) HWY_ATTR {
      return hn::RebindMask(kEightTag, hn::Gt(lanes, hn::Set(di, last)));
    };
    const EightPart few = hn::IfThenElse(are_beyond(7), values_from(8), values_from(0));
    if constexpr (kLayout == CornerLayout::kFew) return few;
    return hn::IfThenElse(are_beyond(15), values_from(16), few);
#endif
#else
    HWY_ALIGN float values[kPartLanes];
    for (size_t i = 0; i < kPartLanes; ++i) values[i] = vertices[indices[i]];
    return hn::Load(kEightTag, values);
#endif
  }
};

/// The corners of a block as it is.
HWY_INLINE CornerLanes DecodeCorners(const LeafBlock& block, size_t part, size_t step = 0) {
  switch (LayoutOf(block)) {
    case CornerLayout::kPrepared:
    case CornerLayout::kByLane:
      return LeafCorners<CornerLayout::kByLane>{block, part, step}.All();
    case CornerLayout::kFew:
      return LeafCorners<CornerLayout::kFew>{block, part, step}.All();
    default:
      return LeafCorners<CornerLayout::kMany>{block, part, step}.All();
  }
}

/// The triangles of a block that does not move, as the triangle test wants them.
inline void PrepareFacets(const LeafBlock& block, PreparedFacets& facets) {
  for (size_t part = 0; part < kParts; ++part) {
    const CornerLanes corners = DecodeCorners(block, part);
    const auto triangles = corners.Triangles();
    const auto put = [&](EightPart values, float* lanes)
                         HWY_ATTR { hn::StoreU(values, kEightTag, lanes + part * kPartLanes); };
    for (int axis = 0; axis < 3; ++axis) {
      const PlanesOnAxis own = corners.OwnPlanes(axis);
      put(triangles.v0[axis], facets.v0[axis]);
      put(triangles.e1[axis], facets.e1[axis]);
      put(triangles.e2[axis], facets.e2[axis]);
      put(triangles.ng[axis], facets.ng[axis]);
      put(own.lower, facets.lower[axis]);
      put(own.upper, facets.upper[axis]);
    }
  }
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

/// The corners of a part of a block that moves, at a moment.
HWY_INLINE CornerLanes CornersAt(const LeafBlock& block, size_t part, const Moment& moment) {
  return Interpolate(DecodeCorners(block, part, moment.step),
                     DecodeCorners(block, part, moment.step + 1), moment.fraction);
}

/// Where one ray meets some triangles. Not all of them count: see own_box-inl.h.
struct FacetCrossing {
  uint64_t lanes = 0;     ///< that it meets, a bit each; what follows means nothing in others
  uint64_t within_limit;  ///< and that pass Embree's test against tfar
  EightPart t;
  EightPart u, v;  ///< times divisor
  EightPart divisor;

  /// The lane that is asked first whether it counts, or kPartLanes if there is none: of any hits
  /// one that lies within tfar, of closest ones the one that is nearest and nearer than `limit`,
  /// which is set to its distance. False if names decide: one is as near as another, or as what the
  /// ray has, or, `at_limit` of a ray that has nothing, as its end.
  template <Query kQuery>
  HWY_INLINE bool FindFirst(bool at_limit, float& limit, size_t& lane) const {
    if constexpr (kQuery == Query::kClosest) return FindNearest(at_limit, limit, lane);
    const uint64_t within = lanes & within_limit;
    lane = within == 0 ? kPartLanes : hwy::Num0BitsBelowLS1Bit_Nonzero64(within);
    return true;
  }

  /// The same of a ray as it stands; `limit` is set to its end where there is no lane.
  template <Query kQuery>
  HWY_INLINE bool FindFirst(const RayRecord& ray, float& limit, size_t& lane) const {
    limit = ray.tfar;
    return FindFirst<kQuery>((ray.state & RayRecord::kAtLimit) != 0, limit, lane);
  }

 private:
  HWY_INLINE bool FindNearest(bool at_limit, float& nearest, size_t& lane) const {
    HWY_ALIGN float keys[kPartLanes];
    hn::Store(t, kEightTag, keys);
    lane = kPartLanes;
    for (uint64_t left = lanes; left != 0; left &= left - 1) {
      const size_t i = hwy::Num0BitsBelowLS1Bit_Nonzero64(left);
      if (HWY_LIKELY(keys[i] < nearest)) {
        nearest = keys[i];
        lane = i;
      } else if (HWY_UNLIKELY(CompareHits(keys[i], within_limit >> i & 1, nearest,
                                          at_limit && lane == kPartLanes,
                                          true) != Closeness::kFarther)) {
        return false;
      }
    }
    return true;
  }
};

/// A ray in all lanes.
struct SpreadRay {
  const RayRecord& ray;

  HWY_INLINE EightPart org(int axis) const { return hn::Set(kEightTag, ray.org[axis]); }
  HWY_INLINE EightPart dir(int axis) const { return hn::Set(kEightTag, ray.dir[axis]); }
  HWY_INLINE EightPart reciprocal(int axis) const {
    return hn::Set(kEightTag, ray.reciprocal[axis]);
  }
  HWY_INLINE EightPart tnear() const { return hn::Set(kEightTag, ray.tnear); }
  HWY_INLINE EightPart tfar() const { return hn::Set(kEightTag, ray.tfar); }

#if HWY_TARGET != HWY_SCALAR
  HWY_INLINE LoneLine line() const {
    return {hn::Load(kCornerTag, ray.org), hn::Load(kCornerTag, ray.reciprocal), ray.tnear};
  }
#endif
};

/// What an eight-lane test without a reciprocal wants of a ray.
template <class Ray>
HWY_INLINE TestRaysOf<EightPart> TestRaysFrom(const Ray& ray) {
  TestRaysOf<EightPart> rays;
  for (int axis = 0; axis < 3; ++axis) {
    rays.org[axis] = ray.org(axis);
    rays.dir[axis] = ray.dir(axis);
  }
  rays.tnear = ray.tnear();
  rays.tfar = ray.tfar();
  return rays;
}

/// Where some rays cross the planes of some triangles, and which of these they meet.
template <class Vec>
struct PlaneCrossing {
  PairTermsOf<Vec> terms;
  Vec t;  ///< T
  hn::Mask<hn::DFromV<Vec>> meet;

  HWY_INLINE PlaneCrossing(const TestRaysOf<Vec>& rays, const TestTrianglesOf<Vec>& triangles)
      : terms(EdgeTerms(rays.org, rays.dir, triangles)),
        t(DepthTerm(triangles, terms)),
        // Both before one branch, which is hard enough to foresee.
        meet(hn::And(PassesInside(terms), MeetsInDepth(rays, t, terms.den))) {}
};

/// What is left to find out where some lanes meet.
HWY_INLINE FacetCrossing FinishCrossing(const TestRaysOf<EightPart>& rays,
                                        const PlaneCrossing<EightPart>& plane) {
  FacetCrossing crossing;
  crossing.lanes = Bits(kEightTag, plane.meet);
  crossing.within_limit = Bits(kEightTag, IsWithinLimit(rays, plane.t, plane.terms.den));
  crossing.t = hn::Div(plane.t, plane.terms.den);
  crossing.u = plane.terms.u;
  crossing.v = plane.terms.v;
  crossing.divisor = plane.terms.den;
  return crossing;
}

/// `ray` is as SpreadRay, `corners` are those of the triangles; see LeafCorners::Again.
template <bool kRobust, class Ray, class Corners>
HWY_INLINE FacetCrossing CrossFacets(const Ray& ray, const TestTrianglesOf<EightPart>& triangles,
                                     const Corners& corners) {
  FacetCrossing crossing;
  const TestRaysOf<EightPart> rays = TestRaysFrom(ray);
  if constexpr (!kRobust) {
    const PlaneCrossing<EightPart> plane(rays, triangles);
    if (HWY_LIKELY(hn::AllFalse(kEightTag, plane.meet))) return crossing;
    return FinishCrossing(rays, plane);
  }
  CornerLanes all;
  for (int axis = 0; axis < 3; ++axis) all.Set(axis, corners.OnAxis(axis));
  const auto terms = TestRobustly(rays, triangles, all.v1, all.v2);
  auto meet = terms.meet;
  if (HWY_LIKELY(hn::AllFalse(kEightTag, meet))) return crossing;
  crossing.t = hn::Div(Dot(triangles.ng, terms.v0), terms.den);
  meet = hn::And(meet, MeetsAtDistance(rays, crossing.t));
  if (hn::AllFalse(kEightTag, meet)) return crossing;
  crossing.lanes = Bits(kEightTag, meet);
  crossing.within_limit = crossing.lanes;
  crossing.u = terms.u;
  crossing.v = terms.v;
  crossing.divisor = terms.sum;
  return crossing;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_CROSS_FACETS_INL_H_
