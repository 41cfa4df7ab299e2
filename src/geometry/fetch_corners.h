// Fetches what will soon be read of triangles.
#pragma once

#include <hwy/cache_control.h>

#include <cstdint>
#include <cstring>

#include "geometry/geometry_table.h"

namespace dacrt {

inline void FetchIndices(const GeometryTable& geometries, GeometryTable::Name name) {
  hwy::Prefetch(geometries.IndicesOf(name.geometry, name.primitive));
}

/// Reads the indices, which should have been fetched.
inline void FetchCorners(const GeometryTable& geometries, GeometryTable::Name name) {
  const TriangleMesh& mesh = geometries[name.geometry];
  uint32_t index[3];
  std::memcpy(index, geometries.IndicesOf(name.geometry, name.primitive), sizeof(index));
  // Fetching does not fail, whatever the address.
  const auto start = reinterpret_cast<std::uintptr_t>(mesh.vertices);
  for (const uint32_t i : index) {
    hwy::Prefetch(reinterpret_cast<const char*>(start + i * mesh.vertex_stride));
  }
}

}  // namespace dacrt
