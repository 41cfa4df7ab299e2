// Fetches what will soon be read of triangles.
#pragma once

#include <hwy/cache_control.h>

#include <cstdint>
#include <cstring>

#include "geometry/mesh_table.h"

namespace dacrt {

inline void FetchIndices(const MeshTable& meshes, MeshTable::Name name) {
  hwy::Prefetch(meshes.IndicesOf(name.mesh, name.primitive));
}

/// Reads the indices, which should have been fetched.
inline void FetchCorners(const MeshTable& meshes, MeshTable::Name name) {
  const TriangleMesh& mesh = meshes[name.mesh];
  uint32_t index[3];
  std::memcpy(index, meshes.IndicesOf(name.mesh, name.primitive), sizeof(index));
  // Fetching does not fail, whatever the address.
  const auto start = reinterpret_cast<std::uintptr_t>(mesh.vertices);
  for (const uint32_t i : index) {
    hwy::Prefetch(reinterpret_cast<const char*>(start + i * mesh.vertex_stride));
  }
}

}  // namespace dacrt
