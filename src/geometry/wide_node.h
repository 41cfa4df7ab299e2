// A node of the kept partition: up to eight child volumes in 96 bytes.
//
// The volumes are stored in eight bits a face, relative to the node's own box; Ylitie, Karras,
// Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", HPG 2017. A
// volume is never smaller than what it holds, so rounding costs tests and changes no hit.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dacrt {

struct alignas(32) WideNode {
  static constexpr std::size_t kWidth = 8;

  /// What stands in a child's place, in the upper four bits of `child`: a leaf of 1 to
  /// kMostLeafTriangles triangles, a subset that may not be split yet, or a node.
  static constexpr uint16_t kMostLeafTriangles = 13;
  static constexpr uint16_t kSubset = 14;
  static constexpr uint16_t kInner = 15;
  static constexpr uint16_t kOffsetBits = 12;

  float origin[3];
  uint16_t scale[3];  ///< upper half of a float: the size of a step
  uint16_t count;     ///< children
  uint8_t lower[3][kWidth];
  uint8_t upper[3][kWidth];
  uint32_t first_node;   ///< a node: first_node + offset is its number
  uint32_t first_other;  ///< so for a leaf's first triangle, in the kept order, and for a subset
  uint16_t child[kWidth];
  /// The binary tree over the children: gap i, between children i and i + 1, has a rank in bits
  /// 3 i to 3 i + 2; a range of children divides at its gap of least rank.
  uint32_t gaps;

  static uint16_t Child(std::size_t kind, std::size_t offset) {
    return static_cast<uint16_t>(kind << kOffsetBits | offset);
  }
  uint16_t Kind(std::size_t i) const { return child[i] >> kOffsetBits; }
  bool IsLeaf(std::size_t i) const { return Kind(i) <= kMostLeafTriangles; }
  bool IsSubset(std::size_t i) const { return Kind(i) == kSubset; }

  /// Number of the child's first triangle, of the subset, or of the node.
  uint32_t Number(std::size_t i) const {
    const uint32_t offset = child[i] & ((1u << kOffsetBits) - 1);
    return (Kind(i) == kInner ? first_node : first_other) + offset;
  }

  uint32_t GapRank(std::size_t i) const { return (gaps >> (3 * i)) & 7; }
};
static_assert(sizeof(WideNode) == 96);

}  // namespace dacrt
