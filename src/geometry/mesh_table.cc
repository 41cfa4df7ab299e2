#include "geometry/mesh_table.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "scene/scene_parts.h"

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

void MeshTable::AddMesh(const TriangleMesh& mesh, std::size_t place) {
  // Compared before they are added: counts that the caller got wrong may overflow the sum.
  constexpr std::size_t kMostTriangles = std::numeric_limits<uint32_t>::max() - 1;
  if (mesh.triangle_count > kMostTriangles - triangle_count_) {
    throw std::length_error("Scene: more than 2^32 - 2 triangles with the " +
                            std::to_string(mesh.triangle_count) + " of mesh " +
                            std::to_string(place));
  }
  triangle_count_ += mesh.triangle_count;
  all_masks_full_ &= mesh.mask == UINT32_MAX;
  meshes_.push_back(mesh);
}

void MeshTable::NumberTriangles() {
  uint32_t first = 0;
  for (const TriangleMesh& mesh : meshes_) {
    first_.push_back(first);
    first += static_cast<uint32_t>(mesh.triangle_count);
  }
}

MeshTable::MeshTable(std::span<const TriangleMesh> meshes) {
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const TriangleMesh& mesh = meshes[i];
    if (mesh.triangle_count > 0) {
      CheckArray("vertices", i, mesh.vertices, mesh.vertex_stride, mesh.vertex_count);
    }
    CheckArray("triangles", i, mesh.triangles, mesh.triangle_stride, mesh.triangle_count);
    AddMesh(mesh, i);
  }
  std::stable_sort(
      meshes_.begin(), meshes_.end(),
      [](const TriangleMesh& a, const TriangleMesh& b) { return a.geometry_id < b.geometry_id; });
  NumberTriangles();
}

MeshTable::MeshTable(std::span<const Geometry> geometries,
                     std::span<const SceneParts* const> scenes, bool robust) {
  std::vector<std::size_t> order(geometries.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return geometries[a].geometry_id < geometries[b].geometry_id;
  });
  std::vector<Geometry> sorted;
  std::vector<const SceneParts*> sorted_scenes;
  for (const std::size_t i : order) {
    sorted.push_back(geometries[i]);
    sorted_scenes.push_back(scenes[i]);
  }
  auto shapes = std::make_unique<const Shapes>(std::move(sorted), std::move(sorted_scenes), robust);
  for (uint32_t i = 0; i < shapes->size(); ++i) {
    TriangleMesh mesh;
    mesh.triangle_count = shapes->ItemCount(i);
    mesh.geometry_id = (*shapes)[i].geometry_id;
    mesh.mask = (*shapes)[i].mask;
    AddMesh(mesh, order[i]);
    if (scenes[order[i]]) all_masks_full_ &= shapes->InstancedScene(i)->meshes.all_masks_full();
  }
  NumberTriangles();
  shapes_ = std::move(shapes);
}

}  // namespace dacrt
