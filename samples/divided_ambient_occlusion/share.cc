#include "divided_ambient_occlusion/share.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace divided {
namespace {

constexpr float kLongest = 2;  // metres along x

float X(const scenes::Mesh& mesh, uint32_t vertex) { return mesh.positions[3 * size_t(vertex)]; }

// Cuts triangles in two until all are short enough.
void CutLongTriangles(scenes::Mesh& mesh) {
  std::vector<uint32_t>& indices = mesh.indices;
  for (size_t first = 0; first < indices.size();) {
    size_t longest = 0;
    float length = 0;
    for (size_t edge = 0; edge < 3; ++edge) {
      const float extent =
          std::abs(X(mesh, indices[first + edge]) - X(mesh, indices[first + (edge + 1) % 3]));
      if (extent > length) {
        longest = edge;
        length = extent;
      }
    }
    if (length <= kLongest) {
      first += 3;
      continue;
    }
    const uint32_t a = indices[first + longest], b = indices[first + (longest + 1) % 3],
                   c = indices[first + (longest + 2) % 3];
    const uint32_t middle = uint32_t(mesh.VertexCount());
    for (size_t axis = 0; axis < 3; ++axis) {
      mesh.positions.push_back(
          (mesh.positions[3 * size_t(a) + axis] + mesh.positions[3 * size_t(b) + axis]) / 2);
    }
    const uint32_t halves[] = {a, middle, c, middle, b, c};
    std::copy(halves, halves + 3, &indices[first]);
    indices.insert(indices.end(), halves + 3, halves + 6);
  }
}

}  // namespace

scenes::Mesh TakeShare(scenes::Mesh hall, uint32_t rank, uint32_t ranks) {
  CutLongTriangles(hall);
  const size_t triangles = hall.TriangleCount();
  std::vector<float> middles(triangles);
  for (size_t i = 0; i < triangles; ++i) {
    for (size_t corner = 0; corner < 3; ++corner)
      middles[i] += X(hall, hall.indices[3 * i + corner]);
  }
  const auto bound = [&](uint32_t slice) {
    if (slice == 0) return -INFINITY;
    if (slice == ranks) return INFINITY;
    std::vector<float> sorted = middles;
    const auto place = sorted.begin() + std::ptrdiff_t(triangles * slice / ranks);
    std::nth_element(sorted.begin(), place, sorted.end());
    return *place;
  };
  const float lower = bound(rank), upper = bound(rank + 1);

  scenes::Mesh share;
  std::vector<uint32_t> new_vertices(hall.VertexCount(), UINT32_MAX);
  for (size_t i = 0; i < triangles; ++i) {
    if (middles[i] < lower || middles[i] >= upper) continue;
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t old = hall.indices[3 * i + corner];
      uint32_t& vertex = new_vertices[old];
      if (vertex == UINT32_MAX) {
        vertex = uint32_t(share.VertexCount());
        share.positions.insert(share.positions.end(), &hall.positions[3 * size_t(old)],
                               &hall.positions[3 * size_t(old)] + 3);
      }
      share.indices.push_back(vertex);
    }
  }
  return share;
}

}  // namespace divided
