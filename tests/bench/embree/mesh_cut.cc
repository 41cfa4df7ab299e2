#include "mesh_cut.h"

#include <algorithm>
#include <span>
#include <utility>

namespace dacrt::bench {
namespace {

GeometryContent Part(const scenes::Mesh& mesh, std::span<const uint32_t> indices,
                     SceneContent& content) {
  const auto [least, most] = std::ranges::minmax(indices);
  std::vector<uint32_t> own(indices.begin(), indices.end());
  for (uint32_t& index : own) index -= least;
  GeometryContent part;
  part.vertices = {&mesh.positions[3 * std::size_t{least}]};
  part.vertex_count = most - least + 1;
  part.primitive_count = indices.size() / 3;
  part.primitives = content.numbers.emplace_back(std::move(own)).data();
  return part;
}

}  // namespace

GeometryContent WholeMesh(const scenes::Mesh& mesh) {
  GeometryContent geometry;
  geometry.vertices = {mesh.positions.data()};
  geometry.vertex_count = mesh.VertexCount();
  geometry.primitives = mesh.indices.data();
  geometry.primitive_count = mesh.TriangleCount();
  return geometry;
}

void CutIntoParts(const scenes::Mesh& mesh, std::size_t count, SceneContent& content) {
  const std::size_t triangles = mesh.TriangleCount();
  count = std::min(count, triangles);
  const std::span<const uint32_t> indices = mesh.indices;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = triangles * i / count, end = triangles * (i + 1) / count;
    content.geometries.push_back(
        Part(mesh, indices.subspan(3 * first, 3 * (end - first)), content));
  }
}

}  // namespace dacrt::bench
