#include "mesh_shapes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

namespace dacrt::bench {
namespace {

using Imath::V3f;
using Triangle = std::array<uint32_t, 3>;

V3f Vertex(const scenes::Mesh& mesh, uint32_t vertex) {
  const float* const p = &mesh.positions[3 * std::size_t{vertex}];
  return {p[0], p[1], p[2]};
}

// The two as a quad, if the second has an edge of the first the other way round.
std::optional<QuadCorners> Join(const Triangle& one, const Triangle& two) {
  for (int i = 0; i < 3; ++i) {
    const uint32_t from = one[i], to = one[(i + 1) % 3], apex = one[(i + 2) % 3];
    for (int j = 0; j < 3; ++j) {
      if (two[j] != to || two[(j + 1) % 3] != from) continue;
      return QuadCorners{apex, from, two[(j + 2) % 3], to};
    }
  }
  return std::nullopt;
}

// A cell of a grid whose rows are `stride` vertices apart.
struct Cell {
  uint32_t first;
  uint32_t stride;
  bool operator==(const Cell&) const = default;
};

// The cell that the quad is, if its vertices are numbered i, i + 1, i + 1 + stride, i + stride.
std::optional<Cell> AsCell(const QuadCorners& quad) {
  for (int i = 0; i < 4; ++i) {
    const uint32_t a = quad[i], b = quad[(i + 1) % 4], c = quad[(i + 2) % 4], d = quad[(i + 3) % 4];
    if (b == a + 1 && c == d + 1 && d > b) return Cell{a, d - a};
  }
  return std::nullopt;
}

class GridBuilder {
 public:
  explicit GridBuilder(const scenes::Mesh& mesh)
      : mesh_(mesh),
        positions_(mesh.positions.begin(), mesh.positions.begin() + 3 * mesh.VertexCount()) {}

  void Add(const QuadCorners& quad) {
    const std::optional<Cell> cell = AsCell(quad);
    if (!cell) {
      AddAlone(quad);
      return;
    }
    if (!row_.empty() && cell->stride == row_.front().stride &&
        cell->first == row_.back().first + 1 && row_.size() < kMostCells) {
      row_.push_back(*cell);
      return;
    }
    FinishRow();
    row_.push_back(*cell);
  }

  SceneContent Finish() {
    FinishRow();
    SceneContent content;
    positions_.push_back(0);  // Embree reads it with the last vertex
    std::vector<uint32_t> words;
    for (const RTCGrid& grid : grids_) {
      words.insert(words.end(), {grid.startVertexID, grid.stride,
                                 std::bit_cast<uint32_t>(std::array{grid.width, grid.height})});
    }
    GeometryContent& geometry = content.geometries.emplace_back();
    geometry.type = RTC_GEOMETRY_TYPE_GRID;
    geometry.vertex_count = positions_.size() / 3;
    geometry.primitive_count = grids_.size();
    geometry.vertices = {content.floats.emplace_back(std::move(positions_)).data()};
    geometry.primitives = content.numbers.emplace_back(std::move(words)).data();
    return content;
  }

 private:
  static constexpr std::size_t kMostCells = 32'000;  // a side; Embree's limit is 32,766

  // A row of cells that lies on the last grid makes it higher.
  void FinishRow() {
    if (row_.empty()) return;
    const auto [first, stride] = row_.front();
    const auto width = static_cast<unsigned short>(row_.size() + 1);
    if (!grids_.empty()) {
      RTCGrid& last = grids_.back();
      if (last.stride == stride && last.width == width && last.height < kMostCells &&
          first == last.startVertexID + (last.height - 1) * stride) {
        ++last.height;
        row_.clear();
        return;
      }
    }
    grids_.push_back({first, stride, width, 2});
    row_.clear();
  }

  void AddAlone(const QuadCorners& quad) {
    FinishRow();
    const auto start = static_cast<uint32_t>(positions_.size() / 3);
    for (const int corner : {0, 1, 3, 2}) {
      const V3f vertex = Vertex(mesh_, quad[corner]);
      positions_.insert(positions_.end(), {vertex.x, vertex.y, vertex.z});
    }
    grids_.push_back({start, 2, 2, 2});
  }

  const scenes::Mesh& mesh_;
  std::vector<float> positions_;
  std::vector<RTCGrid> grids_;
  std::vector<Cell> row_;
};

}  // namespace

std::vector<QuadCorners> PairTriangles(const std::vector<uint32_t>& indices) {
  std::vector<QuadCorners> quads;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const Triangle one = {indices[i], indices[i + 1], indices[i + 2]};
    if (i + 3 < indices.size()) {
      if (const auto quad = Join(one, {indices[i + 3], indices[i + 4], indices[i + 5]})) {
        quads.push_back(*quad);
        i += 3;
        continue;
      }
    }
    quads.push_back({one[0], one[1], one[2], one[2]});
  }
  return quads;
}

SceneContent Quads(const BenchScene& scene) {
  SceneContent content;
  std::vector<uint32_t>& indices = content.numbers.emplace_back();
  for (const QuadCorners& quad : PairTriangles(scene.mesh.indices)) {
    indices.insert(indices.end(), quad.begin(), quad.end());
  }
  GeometryContent& geometry = content.geometries.emplace_back();
  geometry.type = RTC_GEOMETRY_TYPE_QUAD;
  geometry.vertices = {scene.mesh.positions.data()};
  geometry.vertex_count = scene.mesh.VertexCount();
  geometry.primitives = indices.data();
  geometry.primitive_count = indices.size() / 4;
  return content;
}

SceneContent Grids(const BenchScene& scene) {
  GridBuilder builder(scene.mesh);
  for (const QuadCorners& quad : PairTriangles(scene.mesh.indices)) builder.Add(quad);
  return builder.Finish();
}

SceneContent Spheres(const BenchScene& scene) {
  constexpr float kMostRadius = 0.002f;  // of the diagonal: those of walls would fill the room
  const float most = kMostRadius * Bounds(scene.mesh).size().length();
  SceneContent content;
  std::vector<float>& spheres = content.floats.emplace_back();
  const std::vector<uint32_t>& indices = scene.mesh.indices;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const V3f a = Vertex(scene.mesh, indices[i]), b = Vertex(scene.mesh, indices[i + 1]),
              c = Vertex(scene.mesh, indices[i + 2]);
    const V3f centre = (a + b + c) / 3;
    const float area = (b - a).cross(c - a).length() / 2;
    spheres.insert(spheres.end(),
                   {centre.x, centre.y, centre.z, std::min(most, std::sqrt(area) / 2)});
  }
  GeometryContent& geometry = content.geometries.emplace_back();
  geometry.type = RTC_GEOMETRY_TYPE_SPHERE_POINT;
  geometry.vertices = {spheres.data()};
  geometry.vertex_count = indices.size() / 3;
  return content;
}

}  // namespace dacrt::bench
