// The meshes of a committed scene, in the order in which equal distances are decided.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "dacrt/dacrt.h"
#include "geometry/shapes.h"

namespace dacrt {

/// The three corners of a triangle.
struct Corners {
  float v[3][3];
};

/// Meshes sorted by geometry ID, so that (mesh, primitive) compares as (geomID, primID) does.
class MeshTable {
 public:
  /// `scenes` are those that instances show, null for other geometries.
  /// Throws as Scene's constructor does.
  MeshTable(std::span<const Geometry> geometries, std::span<const SceneParts* const> scenes,
            bool robust);
  explicit MeshTable(std::span<const TriangleMesh> meshes);

  std::span<const TriangleMesh> meshes() const { return meshes_; }
  const TriangleMesh& operator[](uint32_t mesh) const { return meshes_[mesh]; }

  /// Triangles of all meshes, also those that cannot be hit.
  std::size_t triangle_count() const { return triangle_count_; }

  /// The number of a triangle among those of all meshes; `Locate` is the way back.
  uint32_t Number(uint32_t mesh, uint32_t primitive) const { return first_[mesh] + primitive; }

  struct Name {
    uint32_t mesh;
    uint32_t primitive;
  };
  Name Locate(uint32_t number) const {
    uint32_t mesh = 0;
    if (first_.size() > 1) {
      mesh = static_cast<uint32_t>(std::upper_bound(first_.begin(), first_.end(), number) -
                                   first_.begin()) -
             1;
    }
    return {mesh, number - first_[mesh]};
  }

  /// Whether there is nothing but still triangles without filter functions, so that the triangle
  /// test is all that a direct solve needs.
  bool is_plain() const { return is_plain_; }

  /// Whether a mesh is of still triangles. Others have as many triangles as their geometries have
  /// items, and no vertices.
  bool HasTriangles(uint32_t mesh) const { return meshes_[mesh].triangles != nullptr; }

  /// Lanes of a leaf that a primitive of a mesh fills (see leaf/leaf_block.h).
  std::size_t LanesOf(uint32_t mesh) const { return lanes_[mesh]; }
  bool all_fill_one_lane() const { return all_fill_one_lane_; }
  const Shapes& shapes() const { return *shapes_; }

  /// Whether every mesh, those of instanced scenes included, accepts every ray whose mask is not 0.
  bool all_masks_full() const { return common_mask_ == UINT32_MAX; }

  /// Whether every mesh is known to accept every ray whose mask holds `mask`: there is a bit that
  /// all masks have.
  bool AllAccept(uint32_t mask) const { return all_masks_full() || (common_mask_ & mask) != 0; }

  /// Where the indices of a triangle's corners stand; of meshes of triangles.
  const char* IndicesOf(uint32_t mesh, uint32_t primitive) const {
    const TriangleMesh& m = meshes_[mesh];
    return static_cast<const char*>(m.triangles) + std::size_t{primitive} * m.triangle_stride;
  }

  /// Reads the corners. False, and nothing read outside the vertices, if an index is too large.
  bool ReadCorners(uint32_t mesh, uint32_t primitive, Corners& corners) const {
    const TriangleMesh& m = meshes_[mesh];
    uint32_t index[3];
    std::memcpy(index, IndicesOf(mesh, primitive), sizeof(index));
    if (index[0] >= m.vertex_count || index[1] >= m.vertex_count || index[2] >= m.vertex_count) {
      return false;
    }
    for (int corner = 0; corner < 3; ++corner) {
      std::memcpy(corners.v[corner],
                  static_cast<const char*>(m.vertices) + index[corner] * m.vertex_stride,
                  sizeof(corners.v[corner]));
    }
    return true;
  }

 private:
  void Add(const TriangleMesh& mesh);

  std::vector<TriangleMesh> meshes_;
  std::vector<uint32_t> first_;  ///< numbers of the first triangles
  std::vector<uint8_t> lanes_;
  std::size_t triangle_count_ = 0;
  uint32_t common_mask_ = UINT32_MAX;  ///< bits that all masks have
  bool is_plain_;
  bool all_fill_one_lane_ = true;
  std::unique_ptr<const Shapes> shapes_;
};

}  // namespace dacrt
