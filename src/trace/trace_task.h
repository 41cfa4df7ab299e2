// Some rays against one scene, or against an instance in it: what the recursion works on.
#pragma once

#include <cstring>

#include "dacrt/dacrt.h"
#include "rays/ray_lists.h"
#include "rays/ray_record.h"
#include "runtime/split_memory.h"
#include "scene/scene_parts.h"

namespace dacrt {

/// What hits and callbacks need to know of the call.
struct CallFrame {
  template <class T>
  T Read(RayView::Component component, uint32_t ray, T absent) const {
    if (component == RayView::kAbsent) return absent;
    T value;
    std::memcpy(&value, reinterpret_cast<const void*>(view->Address(component, first + ray)),
                sizeof(value));
    return value;
  }

  const RayView* view;  ///< null where no callback can be called
  std::size_t first;    ///< ray of the view with which the piece begins
  const CallOptions& options;
  uint32_t no_instance;  ///< what hits outside of instances get
};

struct TraceTask {
  const SceneParts& scene;
  PartitionView partition;
  RayRecord* rays;
  FullHit* hits;  ///< by ray number; closest-hit queries only
  bool checks_masks;
  const CallFrame& frame;
  SplitMemory& split_memory;
  InstanceMemory instance_memory;
  Statistics* statistics;  ///< null on the short way
  uint32_t instance_id;    ///< what hits get
  const uint32_t* callers = nullptr;  ///< numbers of the caller's rays; null: those of `rays`

  uint32_t CallerOf(RayNumber ray) const { return callers ? callers[ray] : ray; }
};

}  // namespace dacrt
