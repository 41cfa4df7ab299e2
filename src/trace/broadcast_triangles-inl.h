// The triangles of a leaf against the rays in the lanes of a group.

#if defined(DACRT_TRACE_BROADCAST_TRIANGLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_BROADCAST_TRIANGLES_INL_H_
#undef DACRT_TRACE_BROADCAST_TRIANGLES_INL_H_
#else
#define DACRT_TRACE_BROADCAST_TRIANGLES_INL_H_
#endif

#include "leaf/cross_facets-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Where the rays in the lanes of a vector meet a triangle, of which not all need do so.
struct TriangleMeeting {
  M meet;          ///< those that do; the rest means nothing for others
  M within_limit;  ///< they pass Embree's test against tfar
  V t;
  V u, v;  ///< times divisor
  V divisor;
  V key;  ///< the distance that decides (see triangle_test-inl.h)
};

/// The triangles of a leaf, to be broadcast one after the other.
class BroadcastTriangles {
 public:
  /// `may_meet` says of boxes in the lanes of a vector whether a ray may meet what is in them.
  template <class MayMeet>
  HWY_INLINE BroadcastTriangles(const LeafBlock& block, const MayMeet& may_meet)
      : block_(block), facets_(&block.prepared()) {
    if (HWY_UNLIKELY(!block.is_prepared)) {
      PrepareFacets(block, own_);
      facets_ = &own_;
    }
    for (size_t part = 0; part < kParts; ++part) {
      const size_t first = part * kPartLanes;
      WideBoxOf<EightPart> box;
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = hn::LoadU(kEightTag, facets_->lower[axis] + first);
        box.upper[axis] = hn::LoadU(kEightTag, facets_->upper[axis] + first);
      }
      candidates_ |= may_meet(box) << first;
    }
    candidates_ &= (1u << block.lanes) - 1;
  }

  /// Those that a ray may meet, a bit each.
  uint32_t candidates() const { return candidates_; }

  HWY_INLINE TestTriangles Get(size_t i) const {
    TestTriangles triangle;
    for (int axis = 0; axis < 3; ++axis) {
      triangle.v0[axis] = hn::Set(kFloat, facets_->v0[axis][i]);
      triangle.e1[axis] = hn::Set(kFloat, facets_->e1[axis][i]);
      triangle.e2[axis] = hn::Set(kFloat, facets_->e2[axis][i]);
      triangle.ng[axis] = hn::Set(kFloat, facets_->ng[axis][i]);
    }
    return triangle;
  }

  /// Whether any of the rays in some lanes meets triangle `i`, and where.
  template <bool kRobust>
  HWY_INLINE bool Meet(size_t i, const TestTriangles& triangle, const TestRays& rays, M lanes,
                       TriangleMeeting& meeting) const {
    if constexpr (kRobust) {
      V v1[3], v2[3];
      GetCorner(i, 1, v1);
      GetCorner(i, 2, v2);
      const auto terms = TestRobustly(rays, triangle, v1, v2);
      M meet = hn::And(terms.meet, lanes);
      if (HWY_LIKELY(hn::AllFalse(kFloat, meet))) return false;
      const V t = hn::Div(Dot(triangle.ng, terms.v0), terms.den);
      meet = hn::And(meet, MeetsAtDistance(rays, t));
      V entry;
      if (hn::AllFalse(kFloat, meet) || !EnterBox(i, rays, meet, entry)) return false;
      meeting = {meet, meet, t, terms.u, terms.v, terms.sum, hn::Max(t, entry)};
    } else {
      const auto terms = EdgeTerms(rays.org, rays.dir, triangle);
      M meet = hn::And(PassesInside(terms), lanes);
      if (HWY_LIKELY(hn::AllFalse(kFloat, meet))) return false;
      const V depth = DepthTerm(triangle, terms);
      meet = hn::And(meet, MeetsInDepth(rays, depth, terms.den));
      V entry;
      if (hn::AllFalse(kFloat, meet) || !EnterBox(i, rays, meet, entry)) return false;
      const V t = hn::Div(depth, terms.den);
      meeting = {meet,
                 IsWithinLimit(rays, depth, terms.den),
                 t,
                 terms.u,
                 terms.v,
                 terms.den,
                 hn::Max(t, entry)};
    }
    return true;
  }

 private:
  HWY_INLINE void GetCorner(size_t i, size_t corner, V* values) const {
    const float* const vertex = block_.vertex_data() + block_.indices()[corner * kLeafLanes + i];
    for (size_t axis = 0; axis < 3; ++axis) {
      values[axis] = hn::Set(kFloat, vertex[axis * block_.vertices]);
    }
  }

  /// Leaves those of `meet` that enter the triangle's own box; false if there are none.
  HWY_INLINE bool EnterBox(size_t i, const TestRays& rays, M& meet, V& entry) const {
    WideBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = hn::Set(kFloat, facets_->lower[axis][i]);
      box.upper[axis] = hn::Set(kFloat, facets_->upper[axis][i]);
    }
    const Interval interval = IntersectBox(box, rays.org, rays.reciprocal);
    meet = hn::And(meet, Enters(interval, rays.tnear, rays.tfar));
    entry = interval.entry;
    return !hn::AllFalse(kFloat, meet);
  }

  const LeafBlock& block_;
  const PreparedFacets* facets_;
  PreparedFacets own_;
  uint32_t candidates_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_BROADCAST_TRIANGLES_INL_H_
