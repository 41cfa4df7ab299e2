// References to triangles: what the recursion partitions in place of the triangles themselves.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/box.h"
#include "geometry/geometry_table.h"

namespace dacrt {

/// A triangle's bounds and name, 32 bytes; or those of an item of another shape, or of a cell of
/// partition/grid.h. A corner and the integer behind it are one 16-byte vector.
struct alignas(16) TriangleRef {
  float lower[3];
  uint32_t primitive;
  float upper[3];
  union {
    uint32_t geometry;
    uint32_t triangle_count;  ///< of a cell
  };
};

/// References [begin, end) of a call's array, with what the recursion must know of them.
struct TriangleRange {
  std::size_t begin;
  std::size_t end;
  Box bounds;   ///< of the triangles
  Box centers;  ///< of lower + upper of each reference, which is twice its centre

  std::size_t count() const { return end - begin; }
};

/// Bounds of one triangle. False if it can not be hit: an index outside the vertices, or a
/// coordinate that is not finite or above kLargestCoordinate in magnitude.
bool BoundTriangle(const GeometryTable& geometries, uint32_t geometry, uint32_t primitive,
                   TriangleRef& ref);
inline bool BoundTriangle(const GeometryTable& geometries, GeometryTable::Name name,
                          TriangleRef& ref) {
  return BoundTriangle(geometries, name.geometry, name.primitive, ref);
}

/// Writes the references of the triangles that can be hit to `refs`, and returns their range. Those
/// that find no room are left out: there can be more than there were at commit only if the caller
/// changed the vertices since.
TriangleRange MakeTriangleRefs(const GeometryTable& geometries, std::span<TriangleRef> refs);

}  // namespace dacrt
