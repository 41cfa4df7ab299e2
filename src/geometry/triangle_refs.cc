#include "geometry/triangle_refs.h"

#include <algorithm>

namespace dacrt {

bool BoundTriangle(const GeometryTable& geometries, uint32_t geometry, uint32_t primitive,
                   TriangleRef& ref) {
  ref.primitive = primitive;
  ref.geometry = geometry;
  if (!geometries.HasTriangles(geometry)) {
    Box bounds;
    if (!geometries.shapes().BoundItem(geometry, primitive, bounds)) return false;
    std::copy_n(bounds.lower, 3, ref.lower);
    std::copy_n(bounds.upper, 3, ref.upper);
    return true;
  }
  Corners corners;
  if (!geometries.ReadCorners(geometry, primitive, corners)) return false;
  for (const auto& corner : corners.v) {
    if (!IsUsable(corner)) return false;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const float a = corners.v[0][axis], b = corners.v[1][axis], c = corners.v[2][axis];
    ref.lower[axis] = std::min(std::min(a, b), c);
    ref.upper[axis] = std::max(std::max(a, b), c);
  }
  return true;
}

TriangleRange MakeTriangleRefs(const GeometryTable& geometries, std::span<TriangleRef> refs) {
  TriangleRange range{0, 0, Box::Empty(), Box::Empty()};
  for (uint32_t geometry = 0; geometry < geometries.size(); ++geometry) {
    for (uint32_t primitive = 0; primitive < geometries[geometry].triangle_count; ++primitive) {
      TriangleRef ref;
      if (!BoundTriangle(geometries, geometry, primitive, ref)) continue;
      if (range.end == refs.size()) return range;
      refs[range.end++] = ref;
      range.bounds.Extend(ref.lower);
      range.bounds.Extend(ref.upper);
      const float center[3] = {ref.lower[0] + ref.upper[0], ref.lower[1] + ref.upper[1],
                               ref.lower[2] + ref.upper[2]};
      range.centers.Extend(center);
    }
  }
  return range;
}

}  // namespace dacrt
