// The geometries of a committed scene, in the order in which equal distances are decided.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include "dacrt/dacrt.h"
#include "geometry/shapes.h"

namespace dacrt {

/// The three corners of a triangle.
struct Corners {
  float v[3][3];
};

/// Geometries of any shape, sorted by geometry ID, so that (geometry, primitive) compares as
/// (geomID, primID) does. A geometry's number is its place here. "Triangles" are items of any shape
/// where nothing else is said.
class GeometryTable {
 public:
  /// `scenes` are those that instances show, null for other geometries.
  /// Throws as Scene's constructor does.
  GeometryTable(std::span<const Geometry> geometries, std::span<const SceneParts* const> scenes,
                bool robust);
  explicit GeometryTable(std::span<const TriangleMesh> meshes);

  std::size_t size() const { return meshes_.size(); }

  /// A geometry as the triangle test reads it. If it is not of still triangles, as many triangles
  /// as it has items, and no vertices.
  const TriangleMesh& operator[](uint32_t geometry) const { return meshes_[geometry]; }

  /// Triangles of all geometries, also those that cannot be hit.
  std::size_t triangle_count() const { return triangle_count_; }

  /// How many still triangles' part of the budget they have: quads and cells of grids are two
  /// triangles, two time steps take half as much again, and user primitives and instances stand
  /// alone in their leaves.
  std::size_t shares() const { return shares_; }

  /// The number of a triangle among those of all geometries; `Locate` is the way back.
  uint32_t Number(uint32_t geometry, uint32_t primitive) const {
    return first_[geometry] + primitive;
  }

  struct Name {
    uint32_t geometry;
    uint32_t primitive;
  };
  Name Locate(uint32_t number) const {
    if (have_one_each_) return {number, 0};
    uint32_t geometry = 0;
    if (first_.size() > 1) {
      geometry = static_cast<uint32_t>(std::upper_bound(first_.begin(), first_.end(), number) -
                                       first_.begin()) -
                 1;
    }
    return {geometry, number - first_[geometry]};
  }

  /// Whether there is nothing but still triangles without filter functions, so that the triangle
  /// test is all that a direct solve needs.
  bool is_plain() const { return is_plain_; }

  /// Whether a geometry is of still triangles.
  bool HasTriangles(uint32_t geometry) const { return meshes_[geometry].triangles != nullptr; }

  /// The number of the only geometry with an ID; nothing if there are none or several.
  std::optional<uint32_t> Find(uint32_t geometry_id) const;

  /// Whether no two geometries have the same.
  bool have_own_ids() const;

  /// Puts a geometry in the place of another one, for which it can be exchanged.
  void Exchange(uint32_t geometry, Shapes::Successor& successor) noexcept;

  /// Puts instances where they will stand, and takes where they stood.
  void Exchange(Shapes::Places& places) noexcept { shapes_->Exchange(places); }

  /// Lanes of a leaf that a primitive of a geometry fills (see leaf/leaf_block.h).
  std::size_t LanesOf(uint32_t geometry) const { return lanes_[geometry]; }
  bool all_fill_one_lane() const { return all_fill_one_lane_; }
  const Shapes& shapes() const { return *shapes_; }

  /// Whether every geometry, those of instanced scenes included, accepts every ray whose mask is
  /// not 0.
  bool all_masks_full() const { return common_mask_ == UINT32_MAX; }

  /// Whether every geometry is known to accept every ray whose mask holds `mask`: there is a bit
  /// that all masks have.
  bool AllAccept(uint32_t mask) const { return all_masks_full() || (common_mask_ & mask) != 0; }

  /// Where the indices of a triangle's corners stand; of still triangles.
  const char* IndicesOf(uint32_t geometry, uint32_t primitive) const {
    const TriangleMesh& m = meshes_[geometry];
    return static_cast<const char*>(m.triangles) + std::size_t{primitive} * m.triangle_stride;
  }

  /// Reads the corners. False, and nothing read outside the vertices, if an index is too large.
  bool ReadCorners(uint32_t geometry, uint32_t primitive, Corners& corners) const {
    const TriangleMesh& m = meshes_[geometry];
    uint32_t index[3];
    std::memcpy(index, IndicesOf(geometry, primitive), sizeof(index));
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
  /// Bits that the masks of a geometry and of all that it shows have.
  uint32_t MaskOf(uint32_t geometry) const;
  void FindCommonMask();

  // In line, and first: what rays ask of a scene that they enter is in its first cache line then.
  std::optional<Shapes> shapes_;  ///< always there, once it is made
  std::vector<TriangleMesh> meshes_;
  std::vector<uint32_t> first_;  ///< numbers of the first triangles
  std::vector<uint8_t> lanes_;
  std::vector<uint32_t> masks_;  ///< bits that each has, and all that it shows
  std::size_t triangle_count_ = 0;
  std::size_t shares_ = 0;
  uint32_t common_mask_ = UINT32_MAX;  ///< bits that all masks have
  bool is_plain_;
  bool all_fill_one_lane_ = true;
  bool have_one_each_ = true;  ///< triangles: as instances, of which there are thousands, have
};

}  // namespace dacrt
