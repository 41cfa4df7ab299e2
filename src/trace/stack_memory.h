// Memory of calls of few rays, on the stack of the caller.
#pragma once

#include <algorithm>

#include "trace/trace_task.h"

namespace dacrt {

template <std::size_t kRays>
struct StackMemory {
  /// Levels of lists; below, each ray goes its own way.
  static constexpr std::size_t kLevels = 20;
  static constexpr std::size_t kInstanceRays = std::min(kRays, std::size_t{64});

  alignas(64) RayRecord rays[kRays];
  FullHit hits[kRays];
  alignas(64) RayRecord instance_rays[kInstanceRays];
  FullHit instance_hits[kInstanceRays];
  uint32_t numbers[kRays];  ///< of the caller's rays, where they are not those of `rays`
  RayNumber outer_rays[kInstanceRays];
  alignas(64) std::byte lists[kLevels * ListBytes(kRays)];

  InstanceMemory ForInstances() { return {instance_rays, instance_hits, outer_rays, kInstanceRays}; }
  ListMemory Lists() { return {lists, lists + sizeof(lists)}; }
};

}  // namespace dacrt
