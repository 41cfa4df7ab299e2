// Small arrays that a call of the recursion needs for one step and no longer. They are part of the
// workspace rather than of the stack, so that the recursion's frames stay small.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/binary_range.h"
#include "geometry/box.h"
#include "geometry/triangle_refs.h"
#include "geometry/wide_node.h"

namespace dacrt {

/// Triangles as the triangle test wants them (see triangle_block-inl.h).
struct alignas(64) TriangleBlock {
  static constexpr std::size_t kCapacity = 64;

  float v0[3][kCapacity];
  float e1[3][kCapacity];     ///< v0 - v1
  float e2[3][kCapacity];     ///< v2 - v0
  float ng[3][kCapacity];     ///< e2 x e1, unnormalised
  float lower[3][kCapacity];  ///< of its own box, widened
  float upper[3][kCapacity];
  uint32_t geometry[kCapacity];
  uint32_t primitive[kCapacity];
  std::size_t count;
};

/// The rays that steer a partition.
struct alignas(64) SampleRays {
  static constexpr std::size_t kCapacity = 1024;

  float org[3][kCapacity];
  float reciprocal[3][kCapacity];  ///< of the direction
  float tnear[kCapacity];
  float tfar[kCapacity];
  std::size_t count = 0;
};

/// A bin: how many centres fell into it, and the bounds of their triangles (Wald 2007).
struct Bin {
  Box bounds;
  std::size_t count;
};

/// The two sides of a candidate partition.
struct SplitCandidate {
  Box left_box;
  Box right_box;
  std::size_t left_count;
  std::size_t right_count;
};

/// What becomes a leaf or a node: [begin, end) of what stands in the row below it.
struct alignas(32) PackedRange {
  float lower[3];
  uint32_t begin;
  float upper[3];
  uint32_t end;
};

/// Where a subset of the kept partition is split (see split_subset-inl.h).
struct SubsetScratch {
  /// Triangles up to which a subset is split in one go: with its nodes it fits the second-level
  /// cache.
  static constexpr std::size_t kTriangles = 2048;
  static constexpr std::size_t kNodes = 1024;
  static constexpr std::size_t kBins = 16;

  TriangleRef refs[kTriangles];
  TriangleRef spare[kTriangles];  ///< for references that move
  union {
    uint32_t codes[2][kTriangles];  ///< see sort_along_curve-inl.h
    uint32_t words[kTriangles];     ///< bits of leaves' ChildWords, see buy_nodes-inl.h
  };
  union {
    struct {
      union {
        BinaryRange ranges[2 * kTriangles];  ///< as many as there can be
        struct {
          PackedRange packed[2 * kTriangles];  ///< of all rows, see pack_along_curve-inl.h
          uint8_t sizes[kTriangles];
        };
      };
      ExactNode nodes[kNodes];
    };
    /// Of a subset that is not much too large to be split in one go (see split_by_grid-inl.h).
    alignas(ExactNode)
        std::byte grid[2 * kTriangles * sizeof(BinaryRange) + kNodes * sizeof(ExactNode)];
  };
  uint32_t order[kTriangles];
  bool is_last[kTriangles];  ///< of its leaf
};

struct Scratch {
  static constexpr int kMaxBins = 32;

  TriangleBlock triangles;
  SampleRays samples;
  Bin bins[3][kMaxBins];
  SplitCandidate candidates[3][kMaxBins];
  uint32_t begins[3][kMaxBins];  ///< triangles that begin in a bin, for cuts
  uint32_t ends[3][kMaxBins];    ///< triangles that end in a bin
  SubsetScratch subset;
};

}  // namespace dacrt
