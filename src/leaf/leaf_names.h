// Whose geometry stands in the lanes of a leaf.
#pragma once

#include <bit>

#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "trace/trace_task.h"

namespace dacrt {

/// Its number among all of the scene: where each item fills one lane, these compare as names do.
inline uint32_t NumberOfLane(const uint32_t* order, const LeafBlock& block, std::size_t lane) {
  return KeptOrder::NumberOf(order[block.PlaceOf(lane)]);
}

/// The name of what stands in the order, in a block whose `geometry` this is.
inline GeometryTable::Name NameOf(const GeometryTable& geometries, uint32_t in_order,
                                  uint32_t geometry) {
  const uint32_t number = KeptOrder::NumberOf(in_order);
  if (geometry == LeafBlock::kSeveral) return geometries.Locate(number);
  return {geometry, number - geometries.Number(geometry, 0)};
}

inline GeometryTable::Name NameOfLane(const GeometryTable& geometries, const uint32_t* order,
                                      const LeafBlock& block, std::size_t lane) {
  return NameOf(geometries, order[block.PlaceOf(lane)], block.geometry);
}
inline GeometryTable::Name NameOfLane(const TraceTask& task, const LeafBlock& block,
                                      std::size_t lane) {
  return NameOfLane(task.scene.geometries, task.partition.order, block, lane);
}

/// Of some lanes, a bit each from lane `first` of a block on, those of geometries that a ray's mask
/// accepts.
inline uint64_t LanesOfMask(const GeometryTable& geometries, const uint32_t* order,
                            const LeafBlock& block, std::size_t first, uint32_t mask,
                            uint64_t lanes) {
  const auto accepts = [&](uint32_t geometry) { return (mask & geometries[geometry].mask) != 0; };
  if (block.geometry != LeafBlock::kSeveral) return accepts(block.geometry) ? lanes : 0;
  for (uint64_t left = lanes; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    const uint32_t geometry = NameOfLane(geometries, order, block, first + lane).geometry;
    if (!accepts(geometry)) lanes &= ~(uint64_t{1} << lane);
  }
  return lanes;
}

/// Its geometry alone, for which the order is seldom asked.
inline uint32_t GeometryOfLane(const TraceTask& task, const LeafBlock& block, std::size_t lane) {
  if (block.geometry != LeafBlock::kSeveral) return block.geometry;
  return NameOfLane(task, block, lane).geometry;
}

}  // namespace dacrt
