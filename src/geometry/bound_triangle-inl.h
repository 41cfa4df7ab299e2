// Bounds of triangles, four coordinates at a time: BoundTriangle of triangle_refs.h for the passes
// over all triangles.

#if defined(DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
#undef DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
#else
#define DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
#endif

#include <cstring>

#include "geometry/corner-inl.h"
#include "geometry/triangle_refs.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The corners of a box; the fourth lanes are scrap.
struct CornerBox {
  Corner lower;
  Corner upper;
};

/// Loads the corners of a triangle of a geometry of still triangles, three coordinates each with
/// something behind. False if that takes another way: an index is outside the vertices, or the last
/// one, behind which there may be nothing.
HWY_INLINE bool LoadCorners(const GeometryTable& geometries, GeometryTable::Name name,
                            Corner* corners) {
  if (HWY_UNLIKELY(!geometries.HasTriangles(name.geometry))) return false;
  const TriangleMesh& mesh = geometries[name.geometry];
  uint32_t index[3];
  memcpy(index, geometries.IndicesOf(name.geometry, name.primitive), sizeof(index));
  for (int i = 0; i < 3; ++i) {
    // With a stride of 0 every vertex is the last one.
    if (size_t{index[i]} + 1 >= mesh.vertex_count || mesh.vertex_stride == 0) return false;
    corners[i] = Corner::LoadUnaligned(reinterpret_cast<const float*>(
        static_cast<const char*>(mesh.vertices) + index[i] * mesh.vertex_stride));
  }
  return true;
}

HWY_INLINE CornerBox BoundCorners(const Corner* c) {
  return {Min(Min(c[0], c[1]), c[2]), Max(Max(c[0], c[1]), c[2])};
}

/// Bounds of a triangle that can be hit.
HWY_INLINE CornerBox BoundUsable(const GeometryTable& geometries, GeometryTable::Name name) {
  Corner corners[3];
  if (HWY_LIKELY(LoadCorners(geometries, name, corners))) return BoundCorners(corners);
  TriangleRef ref{};
  BoundTriangle(geometries, name, ref);
  return {Corner::Load(ref.lower), Corner::Load(ref.upper)};
}

/// Whether no coordinate is too large, infinite, or not a number.
HWY_INLINE bool IsUsable(const Corner* corners) {
  HWY_ALIGN static constexpr uint32_t kXyz[4] = {~0u, ~0u, ~0u, 0};
  const Corner mask = Corner::Load(reinterpret_cast<const float*>(kXyz));
  const auto limit = hn::Set(kCornerTag, kLargestCoordinate);
  bool usable = true;
  for (size_t i = 0; i < kCornerParts; ++i) {
    const auto within = [&](const Corner& corner) HWY_ATTR {
      return hn::Le(hn::Abs(hn::And(corner.part[i], mask.part[i])), limit);
    };
    usable &= hn::AllTrue(
        kCornerTag, hn::And(within(corners[0]), hn::And(within(corners[1]), within(corners[2]))));
  }
  return usable;
}

/// Bounds of a triangle, if it can be hit.
HWY_INLINE bool BoundIfUsable(const GeometryTable& geometries, GeometryTable::Name name,
                              CornerBox& box) {
  Corner corners[3];
  if (HWY_LIKELY(LoadCorners(geometries, name, corners))) {
    box = BoundCorners(corners);
    return IsUsable(corners);
  }
  TriangleRef ref;
  if (!BoundTriangle(geometries, name, ref)) return false;
  box = {Corner::Load(ref.lower), Corner::Load(ref.upper)};
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
