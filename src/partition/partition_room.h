// How much room there is for what a kept partition consists of, and how much of it there must be.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "geometry/geometry_table.h"
#include "geometry/wide_node.h"
#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "runtime/scratch.h"

namespace dacrt::partition_room {

/// Subsets of a scene. One that is small is split in one go, and does not grow (see growth.h). A
/// subset that is split by a grid becomes ones of several hundred triangles; where they should not
/// suffice, subsets stay larger.
constexpr std::size_t SubsetsFor(std::size_t triangles) {
  return triangles <= SubsetScratch::kTriangles ? 1 : 64 + triangles / 256;
}

/// Nodes that stay free for splitting when leaves want room: what complete partitions were measured
/// to take at most, of triangles that overlap. Quads and cells of grids fill two lanes of a leaf.
/// Leaves into which a curve is cut are less full than those of a partition of single triangles.
inline constexpr std::size_t kLanesANode = 14, kLanesANodeOverLargeLeaves = 18;
constexpr std::size_t NodesOver(std::size_t lanes, std::size_t leaf_lanes) {
  if (leaf_lanes == kLeafLanes) return lanes / kLanesANode;
  return lanes * kLeafLanes / (kLanesANodeOverLargeLeaves * leaf_lanes);
}
constexpr std::size_t NodesFor(std::size_t lanes, std::size_t leaf_lanes = kLeafLanes) {
  return 16 + NodesOver(lanes, leaf_lanes);
}

/// Lanes of leaves that the triangles of all geometries from `first` on fill.
inline std::size_t LanesOf(const GeometryTable& geometries, uint32_t first = 0) {
  if (first == 0 && geometries.all_fill_one_lane()) return geometries.triangle_count();
  std::size_t lanes = 0;
  for (uint32_t geometry = first; geometry < geometries.size(); ++geometry) {
    lanes += geometries.LanesOf(geometry) * geometries[geometry].triangle_count;
  }
  return lanes;
}

constexpr std::size_t RoundUp(std::size_t bytes, std::size_t multiple) {
  return (bytes + multiple - 1) / multiple * multiple;
}

constexpr std::size_t OrderBytes(std::size_t triangles) {
  return RoundUp(sizeof(uint32_t) * triangles, alignof(WideNode));
}

/// Order and subsets; nodes and leaves stand behind them.
constexpr std::size_t HeadBytes(std::size_t triangles) {
  return OrderBytes(triangles) + RoundUp(sizeof(Subset) * SubsetsFor(triangles), alignof(WideNode));
}

inline constexpr std::size_t kUnitsANode = sizeof(WideNode) / KeptPartition::kLeafUnit;
inline constexpr std::size_t kUnitsMoreExact = (WideNode::kExactSlots - 1) * kUnitsANode;

/// How many nodes of a partition with room for `units` units may be exact, so that most leaves find
/// room beside: nodes and leaves of scenes were measured to take so much a lane, and 28 where
/// single rays came everywhere, so that one leaf in eight had no copy.
inline constexpr std::size_t kNodeAndLeafBytes = 25;
constexpr std::size_t ExactNodesFor(std::size_t lanes, std::size_t units) {
  const std::size_t bytes = units * KeptPartition::kLeafUnit, others = lanes * kNodeAndLeafBytes;
  return bytes > others ? (bytes - others) / (kUnitsMoreExact * KeptPartition::kLeafUnit) : 0;
}

/// For nodes and leaves, in units of leaves, in a partition of so many bytes.
constexpr std::size_t UnitsFor(std::size_t triangles, std::size_t bytes) {
  return (bytes - HeadBytes(triangles) - KeptPartition::kReadBehind) / KeptPartition::kLeafUnit;
}

}  // namespace dacrt::partition_room
