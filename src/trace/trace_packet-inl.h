// A packet or a single ray in the caller's memory.

#if defined(DACRT_TRACE_TRACE_PACKET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_PACKET_INL_H_
#undef DACRT_TRACE_TRACE_PACKET_INL_H_
#else
#define DACRT_TRACE_TRACE_PACKET_INL_H_
#endif

#include "leaf/finish_hit-inl.h"
#include "rays/load_records-inl.h"
#include "rays/write_record-inl.h"
#include "trace/group_hits-inl.h"
#include "trace/stack_memory.h"
#include "trace/trace_lone-inl.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// One ray, on its way already, through whatever may come.
template <Query kQuery>
HWY_NOINLINE void FinishSingle(const SceneParts& scene, const RayPacket& packet,
                               const CallOptions& options, WorkspacePool& pool, RayRecord& ray,
                               ChildWord child, OpenChildren& open) {
  FullHit hit;
  RayRecord instance_ray;
  FullHit instance_hit;
  uint32_t caller;
  const CallFrame frame{nullptr, &packet, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  const TraceTask task{scene,
                       scene.partition(),
                       &ray,
                       &hit,
                       !scene.geometries.AllAccept(ray.mask),
                       /*keeps_leaf_hits=*/true,
                       frame,
                       split_memory,
                       {&instance_ray, &instance_hit, &caller, 1},
                       nullptr,
                       FinishHit,
                       packet.instance_value};
  OneTracer<kQuery>(task).Resume(child, open, 0, ListMemory{});
  float* const record = static_cast<float*>(packet.values);
  if constexpr (kQuery == Query::kAny) {
    if (ray.tfar < 0) RecordLayout::WriteBlocked(packet, 0);
  } else if (ray.state & RayRecord::kHasHit) {
    uint32_t geometry;
    WriteRecordAtOnce(task.HitOf(0, geometry), record);
  }
}

template <Query kQuery>
void TraceSingle(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                 WorkspacePool& pool) {
  float* const record = static_cast<float*>(packet.values);
  RayRecord ray;
  if (packet.valid && *packet.valid != -1) return;
  if (!LoadRecord(record, packet.has_masks, ray)) return;
  OpenChildren open;
  ChildWord child = scene.kept->root();
  if (HWY_LIKELY(!scene.geometries.shapes().robust() && scene.geometries.AllAccept(ray.mask))) {
    LoneTracer<kQuery> tracer(scene, ray);
    if (HWY_LIKELY(tracer.Trace(child, open))) {
      if constexpr (kQuery == Query::kAny) {
        if (ray.tfar < 0) RecordLayout::WriteBlocked(packet, 0);
      } else if (ray.state & RayRecord::kHasHit) {
        WriteRecordAtOnce(tracer.Hit(packet.instance_value), record);
      }
      return;
    }
  }
  FinishSingle<kQuery>(scene, packet, options, pool, ray, child, open);
}

/// The lanes of a packet as one group.
template <Query kQuery>
void TraceLanes(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                WorkspacePool& pool) {
  GroupLanes lanes;
  const uint32_t active = lanes.LoadPacket(packet);
  if (active == 0) return;
  StackMemory<kGroupRays> memory;
  const CallFrame frame{nullptr, &packet, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  TraceTask task{scene,
                 scene.partition(),
                 memory.rays,
                 memory.hits,
                 !scene.geometries.AllAccept(lanes.CommonMask(active)),
                 /*keeps_leaf_hits=*/true,
                 frame,
                 split_memory,
                 memory.ForInstances(),
                 nullptr,
                 FinishHit,
                 packet.instance_value};
  TraceGroup<kQuery>(task, lanes, active, memory.Lists(), LearntOfGroups<kQuery>(scene));
  if constexpr (kQuery == Query::kAny) {
    ForEachLane(lanes.Blocked(active), [&](size_t lane) {
      RecordLayout::WriteBlocked(packet, static_cast<uint32_t>(lane));
    });
  } else {
    GroupHits(task, lanes, active).Write(packet);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_PACKET_INL_H_
