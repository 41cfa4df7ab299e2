// The triangle test: Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997,
// in the formulation and the operation order of Embree 3, so that hits agree with its own to the
// last bits.

#if defined(DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
#undef DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
#else
#define DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
#endif

#include "geometry/triangle_block-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays for the triangle test: a vector of them, or one in all lanes.
struct TestRays {
  V org[3];
  V dir[3];
  V reciprocal[3];  ///< of dir
  V tnear;
  V tfar;
};

/// Triangles for the triangle test: one in all lanes, or a vector of them.
struct TestTriangles {
  V v0[3];
  V e1[3];
  V e2[3];
  V ng[3];
  WideBox own_box;
};

/// A ray meets a triangle's plane at T / den, and there u = U / den and v = V / den. All have the
/// sign that makes den positive.
struct PairTerms {
  V u;
  V v;
  V den;
  V sign;
  V c[3];  ///< v0 - org
};

HWY_INLINE PairTerms EdgeTerms(const V* org, const V* dir, const TestTriangles& triangles) {
  PairTerms terms;
  V r[3];
  for (int axis = 0; axis < 3; ++axis) {
    terms.c[axis] = hn::Sub(triangles.v0[axis], org[axis]);
  }
  Cross(terms.c, dir, r);
  const V den = Dot(triangles.ng, dir);
  terms.sign = hn::And(den, hn::SignBit(kFloat));
  terms.den = hn::Abs(den);
  terms.u = hn::Xor(Dot(r, triangles.e2), terms.sign);
  terms.v = hn::Xor(Dot(r, triangles.e1), terms.sign);
  return terms;
}

/// T.
HWY_INLINE V DepthTerm(const TestTriangles& triangles, const PairTerms& terms) {
  return hn::Xor(Dot(triangles.ng, terms.c), terms.sign);
}

/// Triangle i in all lanes, or triangles i, i + 1 ... a lane each.
template <bool kBroadcast>
HWY_INLINE TestTriangles LoadTestTriangles(const TriangleBlock& block, size_t i) {
  const auto load = [i](const float* array) HWY_ATTR {
    if constexpr (kBroadcast) return hn::Set(kFloat, array[i]);
    return hn::Load(kFloat, array + i);
  };
  TestTriangles t;
  for (int axis = 0; axis < 3; ++axis) {
    t.v0[axis] = load(block.v0[axis]);
    t.e1[axis] = load(block.e1[axis]);
    t.e2[axis] = load(block.e2[axis]);
    t.ng[axis] = load(block.ng[axis]);
    t.own_box.lower[axis] = load(block.lower[axis]);
    t.own_box.upper[axis] = load(block.upper[axis]);
  }
  return t;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_TRIANGLE_TEST_INL_H_
