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

/// The triangles of a leaf, to be broadcast one after the other.
class BroadcastTriangles {
 public:
  /// `may_meet` says of boxes in the lanes of a vector whether a ray may meet what is in them.
  template <class MayMeet>
  HWY_INLINE BroadcastTriangles(const LeafBlock& block, const MayMeet& may_meet)
      : facets_(&block.prepared()) {
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
  HWY_INLINE WideBox Box(size_t i) const {
    WideBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = hn::Set(kFloat, facets_->lower[axis][i]);
      box.upper[axis] = hn::Set(kFloat, facets_->upper[axis][i]);
    }
    return box;
  }

 private:
  const PreparedFacets* facets_;
  PreparedFacets own_;
  uint32_t candidates_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_BROADCAST_TRIANGLES_INL_H_
