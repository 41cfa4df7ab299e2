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

/// Bounds of a triangle that can be hit.
HWY_INLINE CornerBox BoundUsable(const MeshTable& meshes, MeshTable::Name name) {
  const TriangleMesh& mesh = meshes[name.mesh];
  uint32_t index[3];
  const bool is_plain = HWY_LIKELY(meshes.is_plain());
  if (is_plain) {
    memcpy(index,
           static_cast<const char*>(mesh.triangles) + size_t{name.primitive} * mesh.triangle_stride,
           sizeof(index));
  }
  // The coordinate that is loaded behind a vertex belongs to the next one, so the last vertex is
  // left to the other way; and whatever the caller has changed since.
  const size_t last = mesh.vertex_count - 1;
  if (!is_plain || mesh.vertex_count == 0 || mesh.vertex_stride < sizeof(float) ||
      index[0] >= last || index[1] >= last || index[2] >= last) {
    TriangleRef ref{};
    BoundTriangle(meshes, name, ref);
    return {Corner::Load(ref.lower), Corner::Load(ref.upper)};
  }
  const auto load = [&](uint32_t i) HWY_ATTR {
    return Corner::LoadUnaligned(reinterpret_cast<const float*>(
        static_cast<const char*>(mesh.vertices) + i * mesh.vertex_stride));
  };
  const Corner a = load(index[0]), b = load(index[1]), c = load(index[2]);
  return {Min(Min(a, b), c), Max(Max(a, b), c)};
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_BOUND_TRIANGLE_INL_H_
