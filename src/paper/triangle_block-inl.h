// A few triangles as structure of arrays, ready for the triangle test.

#if defined(DACRT_PAPER_TRIANGLE_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_TRIANGLE_BLOCK_INL_H_
#undef DACRT_PAPER_TRIANGLE_BLOCK_INL_H_
#else
#define DACRT_PAPER_TRIANGLE_BLOCK_INL_H_
#endif

#include "geometry/geometry_table.h"
#include "geometry/triangle_test-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Puts a triangle in place i of `block`, for FinishTriangles.
HWY_INLINE void PlaceTriangle(TriangleBlock& block, size_t i, const float* v0, const float* v1,
                              const float* v2) {
  for (int axis = 0; axis < 3; ++axis) {
    block.v0[axis][i] = v0[axis];
    block.e1[axis][i] = v1[axis];
    block.e2[axis][i] = v2[axis];
  }
}

/// Makes a block of the block.count triangles that have been placed. Behind the last one, up to a
/// full vector, stand triangles of no area, which nothing hits.
HWY_INLINE void FinishTriangles(TriangleBlock& block) {
  const size_t count = block.count;
  for (size_t i = count; i % Lanes() != 0; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      block.v0[axis][i] = block.e1[axis][i] = block.e2[axis][i] = 0;
    }
  }
  for (size_t i = 0; i < count; i += Lanes()) {
    V e1[3], e2[3], ng[3];
    for (int axis = 0; axis < 3; ++axis) {
      const V v0 = hn::Load(kFloat, block.v0[axis] + i);
      const V v1 = hn::Load(kFloat, block.e1[axis] + i);
      const V v2 = hn::Load(kFloat, block.e2[axis] + i);
      hn::Store(WidenDown(hn::Min(hn::Min(v0, v1), v2)), kFloat, block.lower[axis] + i);
      hn::Store(WidenUp(hn::Max(hn::Max(v0, v1), v2)), kFloat, block.upper[axis] + i);
      e1[axis] = hn::Sub(v0, v1);
      e2[axis] = hn::Sub(v2, v0);
      hn::Store(e1[axis], kFloat, block.e1[axis] + i);
      hn::Store(e2[axis], kFloat, block.e2[axis] + i);
    }
    Cross(e2, e1, ng);
    for (int axis = 0; axis < 3; ++axis) hn::Store(ng[axis], kFloat, block.ng[axis] + i);
  }
}

/// Fills `block` with the triangles named by `name(i)`, i < count <= TriangleBlock::kCapacity; a
/// name has the members `geometry` and `primitive`.
template <class Name>
HWY_INLINE void GatherTriangles(const GeometryTable& geometries, size_t count, const Name& name,
                                TriangleBlock& block) {
  block.count = count;
  for (size_t i = 0; i < count; ++i) {
    const auto& triangle = name(i);
    Corners corners;
    if (!geometries.ReadCorners(triangle.geometry, triangle.primitive, corners)) corners = {};
    PlaceTriangle(block, i, corners.v[0], corners.v[1], corners.v[2]);
    block.geometry[i] = triangle.geometry;
    block.primitive[i] = triangle.primitive;
  }
  FinishTriangles(block);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_TRIANGLE_BLOCK_INL_H_
