// What a thread has learnt about how rays are best traced in a scene. None of it changes a hit.
#pragma once

#include "trace/apart_way.h"
#include "trace/child_order.h"
#include "trace/walk_choice.h"

namespace dacrt {

struct Learnt {
  LearntOrder order_of_groups{8, 2048};         ///< costs are visits
  LearntOrder order_of_rays{1 << 15, 1 << 22};  ///< of those in lists; costs are ticks
  WalkChoice walk_of_closest, walk_of_any;
  LearntWay apart_of_closest, apart_of_any;
};

/// What the calling thread has learnt about a scene that it asks for by an address: calls are often
/// smaller than what it takes to learn. It may forget, and may confuse scenes.
Learnt& LearntAbout(const void* scene);

}  // namespace dacrt
