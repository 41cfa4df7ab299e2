// From names to a leaf that carries its geometry.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/mesh_table.h"

namespace dacrt {

struct MadeLeaf {
  std::size_t bytes;
  std::size_t items;
  bool is_whole;  ///< the last item is marked as that of the leaf
};

/// Whether vertices that facets share are looked for: it saves half of the memory, and takes time
/// then and at every test.
enum class SharedVertices { kFind, kRepeat };

/// Writes the blocks (see leaf_block.h) of the items from order[first] on, up to the last one of
/// the leaf, or until kLeafLanes lanes are full, or `most` items, to `blocks`, which has room for
/// kMostLeafBytes and is aligned as a block.
MadeLeaf MakeLeaf(const MeshTable& meshes, const uint32_t* order, uint32_t first, std::size_t most,
                  SharedVertices shared, std::byte* blocks);

/// Puts the geometry of a leaf as it is now into the blocks that MakeLeaf wrote for it, if it fits
/// them. False if it does not, for example because corners that were one have come apart; the
/// blocks are scrap then.
bool RenewLeaf(const MeshTable& meshes, const uint32_t* order, std::size_t room, std::byte* blocks);

}  // namespace dacrt
