#include "trace/trace.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "trace/trace.cc"
#include <hwy/foreach_target.h>

#include "rays/load_records-inl.h"
#include "rays/packet_view.h"
#include "trace/stack_memory.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

template <Query kQuery>
size_t StoreRecords(const RayView& view, size_t first, size_t count, const RayRecord* rays,
                    const FullHit* hits) {
  const RecordLayout layout(view);
  size_t stored = 0;
  for (size_t i = 0; i < count; ++i) {
    if constexpr (kQuery == Query::kAny) {
      // Inactive rays have -1.
      if (!(rays[i].tfar < -1)) continue;
      layout.WriteBlocked(first + i);
    } else {
      if (rays[i].tfar < 0 || !(rays[i].state & RayRecord::kHasHit)) continue;
      layout.WriteHit(first + i, hits[i]);
    }
    ++stored;
  }
  return stored;
}

template <Query kQuery>
void TracePieceFor(const SceneParts& scene, const RayView& view, size_t first, size_t count,
                   const CallOptions& options, Workspace& workspace, Statistics& statistics) {
  RayRecord* const rays = workspace.rays();
  size_t active;
  const uint32_t common_mask = LoadRecords(view, first, count, rays, active);
  const CallFrame frame{&view, first, options, view.instance_value};
  SplitMemory split_memory(workspace.scratch().subset);
  const TraceTask task{scene,        scene.partition(),
                       rays,         workspace.hits(),
                       !scene.meshes.AllAccept(common_mask), frame,
                       split_memory, workspace.instance_memory(),
                       &statistics,  view.instance_value};
  if (active > 0) TraceRays<kQuery>(task, count, workspace.lists());
  statistics.rays += active;
  statistics.hits += StoreRecords<kQuery>(view, first, count, rays, workspace.hits());
  ++statistics.pieces;
}

void TracePiece(Query query, const SceneParts& scene, const RayView& view, size_t first,
                size_t count, const CallOptions& options, Workspace& workspace,
                Statistics& statistics) {
  if (query == Query::kClosest) {
    TracePieceFor<Query::kClosest>(scene, view, first, count, options, workspace, statistics);
  } else {
    TracePieceFor<Query::kAny>(scene, view, first, count, options, workspace, statistics);
  }
}

template <Query kQuery>
void TraceShortFor(const SceneParts& scene, const RayView& view, const CallOptions& options,
                   WorkspacePool& pool) {
  StackMemory<policy::kShortCall> memory;
  size_t active;
  const uint32_t common_mask = LoadRecords(view, 0, view.count, memory.rays, active);
  if (active == 0) return;
  const CallFrame frame{&view, 0, options, view.instance_value};
  SplitMemory split_memory(pool);
  const TraceTask task{scene,        scene.partition(),
                       memory.rays,  memory.hits,
                       !scene.meshes.AllAccept(common_mask), frame,
                       split_memory, memory.ForInstances(),
                       nullptr,      view.instance_value};
  TraceRays<kQuery>(task, view.count, memory.Lists());
  StoreRecords<kQuery>(view, 0, view.count, memory.rays, memory.hits);
}

void TraceShort(Query query, const SceneParts& scene, const RayView& view,
                const CallOptions& options, WorkspacePool& pool) {
  if (query == Query::kClosest) {
    TraceShortFor<Query::kClosest>(scene, view, options, pool);
  } else {
    TraceShortFor<Query::kAny>(scene, view, options, pool);
  }
}

/// One ray: a list of one.
template <Query kQuery>
void TraceSingle(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                 WorkspacePool& pool) {
  float* const record = static_cast<float*>(packet.values);
  RayRecord ray;
  RecordLayout::ReadRecord(record, ray);
  if (!packet.has_masks) ray.mask = UINT32_MAX;
  if (!FinishRecord(ray)) return;
  FullHit hit;
  RayRecord instance_ray;
  FullHit instance_hit;
  uint32_t caller;
  RayView view;
  if (HWY_UNLIKELY(scene.has_callbacks)) view = ViewOf(packet);
  const CallFrame frame{&view, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  const TraceTask task{scene,        scene.partition(),
                       &ray,         &hit,
                       !scene.meshes.AllAccept(ray.mask), frame,
                       split_memory, {&instance_ray, &instance_hit, &caller, 1},
                       nullptr,      packet.instance_value};
  OneTracer<kQuery>(task).Trace(scene.kept->root(), 0, ListMemory{});
  if constexpr (kQuery == Query::kAny) {
    if (ray.tfar < 0) record[static_cast<size_t>(PacketComponent::kTfar)] = ray.tfar;
  } else {
    if (ray.state & RayRecord::kHasHit) RecordLayout::WriteRecord(hit, record);
  }
}

/// Lanes of a packet.
template <Query kQuery>
void TraceLanes(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                WorkspacePool& pool) {
  StackMemory<16> memory;
  const RayView view = ViewOf(packet);
  const RecordLayout layout(view);
  uint32_t common_mask = UINT32_MAX;
  size_t active = 0;
  for (size_t lane = 0; lane < packet.lanes; ++lane) {
    RayRecord& ray = memory.rays[lane];
    ray.tfar = -1;
    if (packet.valid && packet.valid[lane] != -1) continue;
    layout.Read(lane, ray);
    if (!FinishRecord(ray)) continue;
    common_mask &= ray.mask;
    ++active;
  }
  if (active == 0) return;
  const CallFrame frame{&view, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  const TraceTask task{scene,        scene.partition(),
                       memory.rays,  memory.hits,
                       !scene.meshes.AllAccept(common_mask), frame,
                       split_memory, memory.ForInstances(),
                       nullptr,      packet.instance_value};
  TraceRays<kQuery>(task, packet.lanes, memory.Lists());
  StoreRecords<kQuery>(view, 0, packet.lanes, memory.rays, memory.hits);
}

void TracePacket(Query query, const SceneParts& scene, const RayPacket& packet,
                 const CallOptions& options, WorkspacePool& pool) {
  if (query == Query::kClosest) {
    packet.lanes == 1 ? TraceSingle<Query::kClosest>(scene, packet, options, pool)
                      : TraceLanes<Query::kClosest>(scene, packet, options, pool);
  } else {
    packet.lanes == 1 ? TraceSingle<Query::kAny>(scene, packet, options, pool)
                      : TraceLanes<Query::kAny>(scene, packet, options, pool);
  }
}

}  // namespace

const TraceKernels* GetTraceKernels() {
  static constexpr TraceKernels kKernels{TracePiece, TraceShort, TracePacket};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
HWY_EXPORT(GetTraceKernels);
}  // namespace

const TraceKernels& TraceKernelsFor(std::size_t target) {
  return *HWY_DISPATCH_TABLE(GetTraceKernels)[target]();
}

}  // namespace dacrt
#endif  // HWY_ONCE
