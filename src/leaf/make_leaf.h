// From names to a leaf that carries its geometry.
#pragma once

#include <cstddef>
#include <cstdint>

#include "geometry/geometry_table.h"
#include "leaf/leaf_block.h"

namespace dacrt {

/// Items that follow each other in the order, as many as a leaf can hold.
struct LeafItems {
  GeometryTable::Name names[kLeafLanes];
  std::size_t count = 0;
  bool is_last = false;  ///< the last one is marked as that of the leaf
  bool is_plain = true;  ///< all are still triangles
};

/// The items from order[first] on, up to the last one of the leaf, or until kLeafLanes lanes are
/// full, or `most` items.
LeafItems FindItems(const GeometryTable& geometries, const uint32_t* order, uint32_t first,
                    std::size_t most);

/// What a leaf is made of lies anywhere in memory: two steps that fetch it, each of which
/// needs what the one before it has fetched. Whoever has several leaves to make takes each step for
/// all.
void FetchIndices(const GeometryTable& geometries, const LeafItems& items);
void FetchVertices(const GeometryTable& geometries, const LeafItems& items);

struct MadeLeaf {
  std::size_t bytes;
  std::size_t items;
  bool is_whole;  ///< the last item is marked as that of the leaf
};

/// Whether vertices that facets share are looked for: it saves half of the memory, and takes time
/// then and at every test.
enum class SharedVertices { kFind, kRepeat };

/// Writes the blocks (see leaf_block.h) of items that begin at place `first` of the order to
/// `blocks`, which has room for kMostLeafBytes and is aligned as a block.
MadeLeaf MakeLeaf(const GeometryTable& geometries, const LeafItems& items, uint32_t first,
                  SharedVertices shared, std::byte* blocks);

/// All but the vertices of the block that it writes with SharedVertices::kRepeat of so many items
/// that are plain, of one geometry or LeafBlock::kSeveral.
void BeginTrianglesByLane(std::size_t count, uint32_t geometry, uint32_t first, LeafBlock& block);

/// Puts the geometry of a leaf as it is now into the blocks that MakeLeaf wrote for the same items,
/// if it fits their room. False if it does not, for example because corners that were one have come
/// apart; the blocks are scrap then.
bool RenewLeaf(const GeometryTable& geometries, const LeafItems& items, std::size_t room,
               std::byte* blocks);

}  // namespace dacrt
