// A leaf with its geometry: what up to eight lanes of a vector are tested against, in one or two
// cache lines, instead of a chain of misses through order, index buffer and vertex buffer.
//
// A leaf is a row of blocks, one for each kind of what it holds; nearly always there is one. Behind
// the header of 16 bytes stand, by kind:
//
//   facets          indices of the corners, uint8_t[3][kLeafLanes], and the distinct vertices,
//                   float[3][vertices]; of moving ones at each time step, float[steps][3][vertices];
//                   of prepared ones PreparedFacets behind them
//   spheres, discs  float[4][lanes]: centre and radius
//   oriented discs  float[7][lanes]: centre, radius, normal
//   user primitives   float[6][lanes]: their bounds
//   instances       leaf/instance_leaf.h, which begins with its bounds; there is one in a leaf
//   timed           nothing: they are asked for by name
#pragma once

#include <cstddef>
#include <cstdint>

#include "dacrt/geometry.h"

namespace dacrt {

/// Lanes of a leaf: what one vector of 256 bits holds. Triangles and points fill one each, quads
/// and cells of grids two.
inline constexpr std::size_t kLeafLanes = 8;

/// Time steps of which a leaf has copies at most: renderers give their meshes 2, 3, 5 or 9. Without
/// copies rays of 3 steps took 3 to 5 times as long.
inline constexpr uint32_t kMostLeafSteps = 9;

enum class LeafKind : uint8_t {
  kFacets,         ///< triangles, quads, cells of grids
  kMovingFacets,   ///< of one geometry with two to kMostLeafSteps time steps
  kSpheres,        ///
  kDiscs,          ///
  kOrientedDiscs,  ///
  kUser,           ///< user primitives
  kInstances,      ///
};

/// Triangles as the triangle test wants them, a lane each (see geometry/triangle_test-inl.h).
struct PreparedFacets {
  float v0[3][kLeafLanes];
  float e1[3][kLeafLanes];
  float e2[3][kLeafLanes];
  float ng[3][kLeafLanes];
  float lower[3][kLeafLanes];  ///< of its own box, widened
  float upper[3][kLeafLanes];
};

struct alignas(4) LeafBlock {
  static constexpr uint32_t kSeveral = UINT32_MAX;
  /// As many vertices as lanes have corners: a place for each, all lanes of corner 0 first, from
  /// which whole vectors are loaded. Lanes without a facet have one of no area.
  static constexpr uint8_t kByLane = 3 * kLeafLanes;
  /// Of an instance.
  static constexpr std::size_t kInstanceBytes = 112;

  LeafKind kind : 4;
  uint8_t is_last : 1;      ///< of its leaf
  uint8_t is_timed : 1;     ///< moves: asked for by name at each ray's time
  uint8_t is_prepared : 1;  ///< facets, which stand once more as the triangle test wants them
  uint8_t lanes : 4;        ///< of facets the triangles, of which a quad has two; else the items
  uint8_t steps : 4;        ///< of moving facets
  uint8_t vertices;         ///< of facets: the distinct ones, or kByLane
  uint8_t second;           ///< a bit a lane: the second triangle of a quad
  uint32_t first;           ///< place in the order of the leaf's first item
  uint32_t items;     ///< of each lane, four bits a lane: its item's place behind the first one
  uint32_t geometry;  ///< of all lanes, or kSeveral

  /// Bytes behind the header.
  std::size_t DataBytes() const {
    if (is_timed) return 0;
    switch (kind) {
      case LeafKind::kFacets:
        return 3 * kLeafLanes + 3 * sizeof(float) * vertices +
               (is_prepared ? sizeof(PreparedFacets) : 0);
      case LeafKind::kMovingFacets:
        return 3 * kLeafLanes + 3 * sizeof(float) * steps * vertices;
      case LeafKind::kSpheres:
      case LeafKind::kDiscs:
        return 4 * sizeof(float) * lanes;
      case LeafKind::kOrientedDiscs:
        return 7 * sizeof(float) * lanes;
      case LeafKind::kUser:
        return 6 * sizeof(float) * lanes;
      case LeafKind::kInstances:
        return kInstanceBytes;
    }
    return 0;
  }
  /// Bytes from here to where the next block would stand.
  std::size_t Bytes() const { return (sizeof(LeafBlock) + DataBytes() + 3) / 4 * 4; }
  const LeafBlock* Next() const {
    return reinterpret_cast<const LeafBlock*>(reinterpret_cast<const std::byte*>(this) + Bytes());
  }

  const uint8_t* indices() const { return reinterpret_cast<const uint8_t*>(this + 1); }
  const float* vertex_data() const {
    return reinterpret_cast<const float*>(indices() + 3 * kLeafLanes);
  }
  const PreparedFacets& prepared() const {
    return *reinterpret_cast<const PreparedFacets*>(vertex_data() + 3 * kByLane);
  }
  const float* point_data() const { return reinterpret_cast<const float*>(this + 1); }
  /// Lower x, y and z of all, then the upper ones.
  const float* bounds_data() const { return point_data(); }

  uint8_t* indices() { return reinterpret_cast<uint8_t*>(this + 1); }
  float* vertex_data() { return reinterpret_cast<float*>(indices() + 3 * kLeafLanes); }
  PreparedFacets& prepared() {
    return *reinterpret_cast<PreparedFacets*>(vertex_data() + 3 * kByLane);
  }
  float* point_data() { return reinterpret_cast<float*>(this + 1); }

  /// Facets that do not move, and nothing else in the leaf: what most leaves are.
  bool IsPlain() const { return kind == LeafKind::kFacets && is_last && !is_timed; }
  /// User primitives or an instance that do not move, and nothing else.
  bool HoldsItems() const {
    return (kind == LeafKind::kUser || kind == LeafKind::kInstances) && is_last && !is_timed;
  }
  /// What rays are tested against as points with a radius; other blocks may follow.
  bool HoldsPoints() const {
    return kind == LeafKind::kSpheres || kind == LeafKind::kDiscs ||
           kind == LeafKind::kOrientedDiscs;
  }

  uint32_t PlaceOf(std::size_t lane) const { return first + (items >> (4 * lane) & 15); }
};
static_assert(sizeof(LeafBlock) == 16);
static_assert(kMostLeafSteps < 1 << 4);

/// Bytes that the blocks of any leaf fit into, with what whole vectors read behind them.
inline constexpr std::size_t kMostLeafBytes = 3072;

}  // namespace dacrt
