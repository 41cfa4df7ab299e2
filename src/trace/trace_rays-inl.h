// Where a piece of a batch enters the recursion: its rays in lists by the octant of their
// directions.

#if defined(DACRT_TRACE_TRACE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_RAYS_INL_H_
#undef DACRT_TRACE_TRACE_RAYS_INL_H_
#else
#define DACRT_TRACE_TRACE_RAYS_INL_H_
#endif

#include "trace/trace_list-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Traces rays 0 to count - 1 of a task, but for inactive ones, from `root` on.
template <Query kQuery>
void TraceRaysFrom(const TraceTask& task, ChildWord root, size_t count, ListMemory memory) {
  if (count <= policy::kFewRays || !HasRoom(memory, ListBytes(count))) {
    for (size_t i = 0; i < count; ++i) {
      if (task.rays[i].tfar < 0) continue;
      OneTracer<kQuery>(task).Trace(root, static_cast<RayNumber>(i), memory);
    }
    return;
  }
  constexpr uint32_t kOctants = 8;
  size_t ends[kOctants + 1] = {};
  const auto octant_of = [&](size_t i) {
    return task.rays[i].tfar < 0 ? kOctants : task.rays[i].Octant();
  };
  for (size_t i = 0; i < count; ++i) ++ends[octant_of(i)];
  size_t begin = 0;
  for (size_t& end : ends) begin += std::exchange(end, begin);
  RayNumber* const list = CutList<RayNumber>(memory, count + kListSlack);
  for (size_t i = 0; i < count; ++i) list[ends[octant_of(i)]++] = static_cast<RayNumber>(i);
  memset(list + count, 0, kListSlack * sizeof(RayNumber));
  begin = 0;
  for (uint32_t octant = 0; octant < kOctants; ++octant) {
    const size_t rays = ends[octant] - begin;
    if (rays > 0) ListTracer<kQuery>(task, octant).Trace(root, list + begin, rays, memory);
    begin = ends[octant];
  }
}

template <Query kQuery>
void TraceRays(const TraceTask& task, size_t count, ListMemory memory) {
  if (HWY_LIKELY(task.scene.kept != nullptr)) {
    return TraceRaysFrom<kQuery>(task, task.scene.kept->root(), count, memory);
  }
  TraceUnkept(task, [&](const TraceTask& own, ChildWord root) {
    TraceRaysFrom<kQuery>(own, root, count, memory);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_RAYS_INL_H_
