#include "geometry/mesh_table.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace dacrt {
namespace {

void CheckArray(const char* what, std::size_t mesh, const void* address, std::size_t stride,
                std::size_t count) {
  if (count == 0) return;
  const std::string where = "Scene: mesh " + std::to_string(mesh) + ": " + what;
  if (address == nullptr) {
    throw std::invalid_argument(where + " is null, but its count is " + std::to_string(count));
  }
  if (reinterpret_cast<std::uintptr_t>(address) % 4 != 0) {
    throw std::invalid_argument(where + " is not aligned to 4 bytes");
  }
  if (stride % 4 != 0) {
    throw std::invalid_argument(where + " has stride " + std::to_string(stride) +
                                ", which is not a multiple of 4");
  }
}

}  // namespace

MeshTable::MeshTable(std::span<const TriangleMesh> meshes) : meshes_(meshes.begin(), meshes.end()) {
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const TriangleMesh& mesh = meshes_[i];
    if (mesh.triangle_count > 0) {
      CheckArray("vertices", i, mesh.vertices, mesh.vertex_stride, mesh.vertex_count);
    }
    CheckArray("triangles", i, mesh.triangles, mesh.triangle_stride, mesh.triangle_count);
    // Compared before they are added: counts that the caller got wrong may overflow the sum.
    constexpr std::size_t kMostTriangles = std::numeric_limits<uint32_t>::max() - 1;
    if (mesh.triangle_count > kMostTriangles - triangle_count_) {
      throw std::length_error("Scene: more than 2^32 - 2 triangles with the " +
                              std::to_string(mesh.triangle_count) + " of mesh " +
                              std::to_string(i));
    }
    triangle_count_ += mesh.triangle_count;
    all_masks_full_ &= mesh.mask == UINT32_MAX;
  }
  std::stable_sort(
      meshes_.begin(), meshes_.end(),
      [](const TriangleMesh& a, const TriangleMesh& b) { return a.geometry_id < b.geometry_id; });
  uint32_t first = 0;
  for (const TriangleMesh& mesh : meshes_) {
    first_.push_back(first);
    first += static_cast<uint32_t>(mesh.triangle_count);
  }
}

}  // namespace dacrt
