// Where rays enter the recursion: in lists by the octant of their directions.

#if defined(DACRT_TRACE_TRACE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_RAYS_INL_H_
#undef DACRT_TRACE_TRACE_RAYS_INL_H_
#else
#define DACRT_TRACE_TRACE_RAYS_INL_H_
#endif

#include <utility>

#include "rays/load_records-inl.h"
#include "trace/trace_group-inl.h"
#include "trace/trace_list-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays [begin, end) of a task, which run in one octant.
template <Query kQuery>
void TraceOctant(const TraceTask& task, ChildWord root, uint32_t octant, size_t begin, size_t end,
                 ListMemory memory) {
  const size_t count = end - begin;
  if (!HasRoom(memory, ListBytes(count))) {
    for (size_t i = begin; i < end; ++i) {
      OneTracer<kQuery>(task).Trace(root, static_cast<RayNumber>(i), memory);
    }
    return;
  }
  RayNumber* const list = CutList<RayNumber>(memory, count + kListSlack);
  for (size_t i = 0; i < count; ++i) list[i] = static_cast<RayNumber>(begin + i);
  memset(list + count, 0, kListSlack * sizeof(RayNumber));
  ListTracer<kQuery>(task, octant).Trace(root, list, count, memory);
}

template <Query kQuery>
void TraceLoaded(const TraceTask& task, const LoadedRays& rays, ListMemory memory) {
  const ChildWord root = task.scene.kept->root();
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    const size_t begin = rays.begin[octant], end = rays.end[octant];
    if (end > begin) TraceOctant<kQuery>(task, root, octant, begin, end, memory);
  }
}

/// Rays 0 to count - 1 of a task, in no order, from `root` on.
template <Query kQuery>
void TraceRaysFrom(const TraceTask& task, ChildWord root, size_t count, ListMemory memory) {
  if (!HasRoom(memory, ListBytes(count))) {
    for (size_t i = 0; i < count; ++i) {
      OneTracer<kQuery>(task).Trace(root, static_cast<RayNumber>(i), memory);
    }
    return;
  }
  if (count <= kPacketRays) {
    RayNumber list[kPacketRays];
    for (size_t i = 0; i < count; ++i) list[i] = static_cast<RayNumber>(i);
    if (count <= policy::kFewRays) {
      return OneTracer<kQuery>(task).TraceAll(root, list, count, memory);
    }
    GroupLanes<kPacketRays> lanes;
    return GroupTracer<kQuery, kPacketRays>(task, lanes).TraceRecords(root, list, count, memory);
  }
  constexpr uint32_t kOctants = LoadedRays::kOctants;
  size_t ends[kOctants] = {};
  for (size_t i = 0; i < count; ++i) ++ends[task.rays[i].Octant()];
  size_t begin = 0;
  for (size_t& end : ends) begin += std::exchange(end, begin);
  RayNumber* const list = CutList<RayNumber>(memory, count + kListSlack);
  for (size_t i = 0; i < count; ++i) {
    list[ends[task.rays[i].Octant()]++] = static_cast<RayNumber>(i);
  }
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
