// Whose geometry stands in the lanes of a leaf.
#pragma once

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

/// Its geometry alone, for which the order is seldom asked.
inline uint32_t GeometryOfLane(const TraceTask& task, const LeafBlock& block, std::size_t lane) {
  if (block.geometry != LeafBlock::kSeveral) return block.geometry;
  return NameOfLane(task, block, lane).geometry;
}

}  // namespace dacrt
