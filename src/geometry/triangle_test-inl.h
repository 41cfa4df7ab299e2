// The triangle test: Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997,
// in the formulation and the operation order of Embree 3, so that hits agree with its own to the
// last bits. A vector of pairs at a time.
//
// Which hits count is a property of the ray and the triangle alone, and the closest one is the
// least (key, name); so the answer does not depend on the order or grouping in which pairs are
// tested. A pair counts if
//   - the ray passes the edge tests, and T and |den| say tnear < t <= tfar and 0 <= t,
//   - the ray enters the triangle's own box (see ray_box-inl.h) within [max(tnear, 0), tfar],
// and its key is t, or where the ray enters that box if t is smaller. No box around the triangle is
// then entered later than at the key, so none is left out because of a closer hit. The key differs
// from t only on grazing rays, where t is ill-conditioned; it only decides, what the caller gets is
// t.

#if defined(DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
#undef DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
#else
#define DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
#endif

#include <limits>

#include "geometry/ray_box-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// a x b with one rounding less a component where the instruction set has fused operations, in
/// Embree's order.
template <class Vec>
HWY_INLINE void Cross(const Vec* a, const Vec* b, Vec* out) {
  out[0] = hn::MulSub(a[1], b[2], hn::Mul(a[2], b[1]));
  out[1] = hn::MulSub(a[2], b[0], hn::Mul(a[0], b[2]));
  out[2] = hn::MulSub(a[0], b[1], hn::Mul(a[1], b[0]));
}

template <class Vec>
HWY_INLINE Vec Dot(const Vec* a, const Vec* b) {
  return hn::MulAdd(a[0], b[0], hn::MulAdd(a[1], b[1], hn::Mul(a[2], b[2])));
}

/// Rays for the triangle test: a vector of them, or one in all lanes.
template <class Vec>
struct TestRaysOf {
  Vec org[3];
  Vec dir[3];
  Vec reciprocal[3];  ///< of dir
  Vec tnear;
  Vec tfar;
};
using TestRays = TestRaysOf<V>;

/// Triangles for the triangle test: one in all lanes, or a vector of them.
template <class Vec>
struct TestTrianglesOf {
  Vec v0[3];
  Vec e1[3];  ///< v0 - v1
  Vec e2[3];  ///< v2 - v0
  Vec ng[3];  ///< e2 x e1
};
using TestTriangles = TestTrianglesOf<V>;

/// A ray meets a triangle's plane at T / den, and there u = U / den and v = V / den. All have the
/// sign that makes den positive.
template <class Vec>
struct PairTermsOf {
  Vec u;
  Vec v;
  Vec den;
  Vec sign;
  Vec c[3];  ///< v0 - org
};

template <class Vec>
HWY_INLINE PairTermsOf<Vec> EdgeTerms(const Vec* org, const Vec* dir,
                                      const TestTrianglesOf<Vec>& triangles) {
  const hn::DFromV<Vec> d;
  PairTermsOf<Vec> terms;
  Vec r[3];
  for (int axis = 0; axis < 3; ++axis) {
    terms.c[axis] = hn::Sub(triangles.v0[axis], org[axis]);
  }
  Cross(terms.c, dir, r);
  const Vec den = Dot(triangles.ng, dir);
  terms.sign = hn::And(den, hn::SignBit(d));
  terms.den = hn::Abs(den);
  terms.u = hn::Xor(Dot(r, triangles.e2), terms.sign);
  terms.v = hn::Xor(Dot(r, triangles.e1), terms.sign);
  return terms;
}

/// T.
template <class Vec>
HWY_INLINE Vec DepthTerm(const TestTrianglesOf<Vec>& triangles, const PairTermsOf<Vec>& terms) {
  return hn::Xor(Dot(triangles.ng, terms.c), terms.sign);
}

/// Pairs of which the ray passes inside of the triangle's edges, or lies in its plane.
template <class Vec>
HWY_INLINE auto PassesInside(const PairTermsOf<Vec>& terms) {
  const Vec zero = hn::Zero(hn::DFromV<Vec>());
  return hn::And(hn::Ge(hn::Min(terms.u, terms.v), zero),
                 hn::Le(hn::Add(terms.u, terms.v), terms.den));
}

/// T / den may round to tfar or below although T > den * tfar, and a hit at exactly tfar has to be
/// compared by its name: so the depth test here has slack, and whoever takes the hit decides. A
/// distance below the smallest normal number has lost bits, or all of them.
constexpr float kDepthSlack = 1.0f + 0x1p-20f;
constexpr float kDepthSlackAbsolute = std::numeric_limits<float>::min();

/// Pairs that meet the plane within the ray's interval, by T and den. Where T overflows, den * tfar
/// may do so too; then the plane is beyond every finite tfar.
template <class Vec>
HWY_INLINE auto MeetsInDepth(const TestRaysOf<Vec>& rays, Vec t, Vec den) {
  const Vec zero = hn::Zero(hn::DFromV<Vec>());
  const Vec farthest = hn::Max(rays.tfar, SetLike(t, std::numeric_limits<float>::max()));
  const Vec limit =
      hn::Mul(den, hn::MulAdd(rays.tfar, SetLike(t, kDepthSlack), SetLike(t, kDepthSlackAbsolute)));
  return hn::And(hn::And(hn::Gt(den, zero), hn::Ge(t, zero)),
                 hn::And(hn::Lt(hn::Mul(den, rays.tnear), t),
                         hn::And(hn::Le(t, limit), hn::Le(t, farthest))));
}

/// Pairs that lie within tfar by Embree's depth test, T <= den * tfar.
template <class Vec>
HWY_INLINE auto IsWithinLimit(const TestRaysOf<Vec>& rays, Vec t, Vec den) {
  return hn::Le(t, hn::Mul(den, rays.tfar));
}

/// The triangles' own boxes on an axis. Bounds of triangles given by a corner and edges would be
/// rounded; these are of the corners.
template <class Vec>
HWY_INLINE Vec OwnLower(Vec v0, Vec v1, Vec v2) {
  return WidenDown(hn::Min(hn::Min(v0, v1), v2));
}
template <class Vec>
HWY_INLINE Vec OwnUpper(Vec v0, Vec v1, Vec v2) {
  return WidenUp(hn::Max(hn::Max(v0, v1), v2));
}

template <class Vec>
HWY_INLINE WideBoxOf<Vec> OwnBox(const Vec* v0, const Vec* v1, const Vec* v2) {
  WideBoxOf<Vec> box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = OwnLower(v0[axis], v1[axis], v2[axis]);
    box.upper[axis] = OwnUpper(v0[axis], v1[axis], v2[axis]);
  }
  return box;
}

/// Edges and normal of triangles with the given corners.
template <class Vec>
HWY_INLINE TestTrianglesOf<Vec> TrianglesOf(const Vec* v0, const Vec* v1, const Vec* v2) {
  TestTrianglesOf<Vec> triangles;
  for (int axis = 0; axis < 3; ++axis) {
    triangles.v0[axis] = v0[axis];
    triangles.e1[axis] = hn::Sub(v0[axis], v1[axis]);
    triangles.e2[axis] = hn::Sub(v2[axis], v0[axis]);
  }
  Cross(triangles.e2, triangles.e1, triangles.ng);
  return triangles;
}

/// Calls `take(lane)` for each lane that meets.
template <class Take>
HWY_INLINE void ForEachLane(uint64_t lanes, const Take& take) {
  for (; lanes != 0; lanes &= lanes - 1) take(hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes));
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
