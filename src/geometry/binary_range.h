// A binary partition of references, from which the wide nodes of the kept partition are made.
#pragma once

#include <cstdint>

#include "geometry/box.h"
#include "geometry/wide_node.h"

namespace dacrt {

/// References [begin, end), which are a leaf, or split in two.
struct BinaryRange {
  bool IsLeaf() const { return first == 0; }

  Box bounds;
  uint32_t begin;
  uint32_t end;
  uint32_t first;   ///< number of the left half, before that of the right one; 0 for a leaf
  uint32_t parent;  ///< number of the one that it is half of; of all, which is number 0, anything
  float surface;    ///< half of that of its bounds, on a scale on which that of all is at most 1
  /// How many of some places in a node, one to eight, the left half gets; 0 where the range takes
  /// one itself.
  uint8_t left_places[WideNode::kWidth];
  float cost[WideNode::kWidth];  ///< in that many places
  float leaf_surface;            ///< of its leaves together, on the same scale as its own
};

}  // namespace dacrt
