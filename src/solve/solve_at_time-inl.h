// Direct solve of items that may move: each ray against the items as they stand at its time.

#if defined(DACRT_SOLVE_SOLVE_AT_TIME_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_AT_TIME_INL_H_
#undef DACRT_SOLVE_SOLVE_AT_TIME_INL_H_
#else
#define DACRT_SOLVE_SOLVE_AT_TIME_INL_H_
#endif

#include <algorithm>
#include <span>

#include "solve/direct_solve-inl.h"
#include "solve/ray_selection.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Calls `gather(time)` where the items stand elsewhere than for the ray before, and then
/// `test(slot)`, for each ray.
template <class Gather, class Test>
HWY_INLINE void ForEachRayAtItsTime(const SolveTask& task, std::span<const MeshTable::Name> items,
                                    const RaySelection& rays, const Gather& gather,
                                    const Test& test) {
  const Shapes& shapes = task.meshes.shapes();
  const bool moving = std::any_of(items.begin(), items.end(), [&](const MeshTable::Name& item) {
    return shapes.IsMoving(item.mesh);
  });
  bool gathered = false;
  float gathered_time = 0;
  ForEachRay(rays, [&](size_t slot) HWY_ATTR {
    const float time = moving ? task.frame->TimeOf(task.batch.index[slot]) : 0;
    if (!gathered || time != gathered_time) {
      gather(time);
      gathered = true;
      gathered_time = time;
    }
    test(slot);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_AT_TIME_INL_H_
