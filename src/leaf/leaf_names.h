// Whose geometry stands in the lanes of a leaf.
#pragma once

#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "trace/trace_task.h"

namespace dacrt {

inline MeshTable::Name NameOfLane(const TraceTask& task, const LeafBlock& block, std::size_t lane) {
  const uint32_t number = KeptOrder::NumberOf(task.partition.order[block.PlaceOf(lane)]);
  const MeshTable& meshes = task.scene.meshes;
  if (block.geometry == LeafBlock::kSeveral) return meshes.Locate(number);
  return {block.geometry, number - meshes.Number(block.geometry, 0)};
}

}  // namespace dacrt
