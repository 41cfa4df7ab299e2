// From names to a leaf that carries its geometry.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/mesh_table.h"

namespace dacrt {

/// Writes the blocks (see leaf_block.h) of the leaf whose first item stands in order[first], up to
/// the one that is marked as the last, or up to `most` items, to `blocks`, which has room for
/// kMostLeafBytes and is aligned as a block. Returns how many bytes they take.
std::size_t MakeLeaf(const MeshTable& meshes, const uint32_t* order, uint32_t first,
                     std::size_t most, std::byte* blocks);

}  // namespace dacrt
