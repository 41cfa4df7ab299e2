// The triangle test of robust scenes: its edge tests give two triangles that share an edge the same
// number but for its sign, so that no ray passes between them. The volumes of edge and ray by
// Plücker coordinates; Davidovič, Engelhardt, Georgiev, Slusallek, Dachsbacher, "3D rasterization:
// a bridge between rasterization and ray casting", GI 2012.

#if defined(DACRT_GEOMETRY_ROBUST_TEST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_ROBUST_TEST_INL_H_
#undef DACRT_GEOMETRY_ROBUST_TEST_INL_H_
#else
#define DACRT_GEOMETRY_ROBUST_TEST_INL_H_
#endif

#include "geometry/triangle_test-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Six times the volume of the edge from a to b and the ray, from the ray's origin. Swapping a and
/// b changes the sign and nothing else.
template <class Vec>
HWY_INLINE Vec EdgeVolume(const Vec* a, const Vec* b, const Vec* dir) {
  Vec edge[3], sum[3], cross[3];
  for (int axis = 0; axis < 3; ++axis) {
    edge[axis] = hn::Sub(a[axis], b[axis]);
    sum[axis] = hn::Add(a[axis], b[axis]);
  }
  Cross(edge, sum, cross);
  return Dot(cross, dir);
}

/// A ray meets a triangle's plane at Ng v0 / den, and there u = u / sum and v = v / sum.
template <class Vec>
struct RobustTerms {
  Vec u;
  Vec v;
  Vec sum;
  Vec den;
  Vec v0[3];  ///< from the ray's origin
  hn::Mask<hn::DFromV<Vec>> meet;
};

template <class Vec>
HWY_INLINE RobustTerms<Vec> TestRobustly(const TestRaysOf<Vec>& rays,
                                         const TestTrianglesOf<Vec>& triangles,
                                         const Vec* corner1, const Vec* corner2) {
  const hn::DFromV<Vec> d;
  RobustTerms<Vec> terms;
  Vec v1[3], v2[3];
  for (int axis = 0; axis < 3; ++axis) {
    terms.v0[axis] = hn::Sub(triangles.v0[axis], rays.org[axis]);
    v1[axis] = hn::Sub(corner1[axis], rays.org[axis]);
    v2[axis] = hn::Sub(corner2[axis], rays.org[axis]);
  }
  terms.u = EdgeVolume(v2, terms.v0, rays.dir);
  terms.v = EdgeVolume(terms.v0, v1, rays.dir);
  const Vec w = EdgeVolume(v1, v2, rays.dir);
  terms.sum = hn::Add(hn::Add(terms.u, terms.v), w);
  // A ray through an edge belongs to the triangles on both sides, within rounding.
  const Vec slack = hn::Mul(hn::Abs(terms.sum), hn::Set(d, 0x1p-23f));
  const auto inside = hn::Or(hn::Ge(hn::Min(terms.u, hn::Min(terms.v, w)), hn::Neg(slack)),
                             hn::Le(hn::Max(terms.u, hn::Max(terms.v, w)), slack));
  terms.den = Dot(triangles.ng, rays.dir);
  const Vec zero = hn::Zero(d);
  terms.meet = hn::And(inside, hn::And(hn::Ne(terms.den, zero), hn::Ne(terms.sum, zero)));
  return terms;
}

/// Hits count at tnear, too: a ray that goes on from a hit meets again what stands there, so that
/// no hit is lost to a program that walks from one to the next.
template <class Vec>
HWY_INLINE auto MeetsAtDistance(const TestRaysOf<Vec>& rays, Vec t) {
  return hn::And(hn::Ge(t, hn::Zero(hn::DFromV<Vec>())),
                 hn::And(hn::Le(rays.tnear, t), hn::Le(t, rays.tfar)));
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_ROBUST_TEST_INL_H_
