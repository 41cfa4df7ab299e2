// What a leaf holds of an instance that does not move: all that rays begin with that enter it.
// Looked up by way of the geometry, its scene, and what that keeps, it would be several cache
// misses, one after the other, for each ray that comes alone.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "dacrt/transform.h"
#include "geometry/shapes.h"
#include "leaf/leaf_block.h"
#include "partition/kept_partition.h"
#include "scene/scene_parts.h"

namespace dacrt {

/// As long as an instance shows a scene, what that keeps stays where it is (see Scene::Update).
struct InstanceLeaf {
  static InstanceLeaf Of(const Shapes& shapes, uint32_t geometry) {
    InstanceLeaf leaf;
    leaf.scene = shapes.InstancedScene(geometry);
    leaf.Place(shapes, geometry);
    leaf.all = leaf.scene->kept ? &leaf.scene->kept->subset(0) : nullptr;
    leaf.partition = leaf.scene->partition();
    return leaf;
  }

  /// In the block of an instance, which is alone in it.
  static const InstanceLeaf& In(const LeafBlock& block) {
    return *reinterpret_cast<const InstanceLeaf*>(block.bounds_data());
  }

  /// Puts it where the instance stands now.
  void Place(const Shapes& shapes, uint32_t geometry) {
    const Box& bounds = shapes.StillBounds(geometry, 0);
    std::memcpy(lower, bounds.lower, sizeof(lower));
    std::memcpy(upper, bounds.upper, sizeof(upper));
    to_instance = shapes.ToStillInstance(geometry);
  }

  Box Bounds() const {
    return {{lower[0], lower[1], lower[2], 0}, {upper[0], upper[1], upper[2], 0}};
  }

  /// What a walk of the scene begins with, where it keeps something: KeptPartition::root.
  ChildWord Root() const {
    const uint32_t number = all->root.load(std::memory_order_acquire);
    return Subset::IsNode(number) ? ChildWord::Inner(number) : ChildWord::Subset(0);
  }

  float lower[3], upper[3];
  AffineTransform to_instance;
  const SceneParts* scene;
  const Subset* all;  ///< the whole scene; null if nothing is kept
  PartitionView partition;
};
static_assert(sizeof(InstanceLeaf) == LeafBlock::kInstanceBytes);
static_assert(offsetof(InstanceLeaf, lower) == 0);

}  // namespace dacrt
