#include "trace/trace.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "trace/trace.cc"
#include <hwy/foreach_target.h>

#include "leaf/finish_hit-inl.h"
#include "rays/load_records-inl.h"
#include "rays/packet_view.h"
#include "trace/stack_memory.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

/// Rays ahead of which the leaves are fetched that have been hit.
constexpr size_t kFetchHits = 8;

/// Writes what the loaded rays have found to the caller's records. Returns how many found something.
template <Query kQuery>
size_t StoreRecords(const TraceTask& task, const LoadedRays& loaded) {
  const RecordLayout layout(*task.frame.view);
  const auto caller_of = [&](size_t ray) { return task.frame.first + task.callers[ray]; };
  FinishedHits finished(task);
  size_t stored = 0;
  const auto finish = [&]() HWY_ATTR {
    finished.Finish([&](size_t i, const FullHit& hit) HWY_ATTR {
      layout.WriteHit(caller_of(finished.number(i)), hit);
    });
  };
  for (uint32_t octant = 0; octant < LoadedRays::kOctants; ++octant) {
    for (size_t i = loaded.begin[octant]; i < loaded.end[octant]; ++i) {
      const RayRecord& ray = task.rays[i];
      if constexpr (kQuery == Query::kAny) {
        if (!(ray.tfar < 0)) continue;
        layout.WriteBlocked(caller_of(i));
      } else {
        if (!(ray.state & RayRecord::kHasHit)) continue;
        if (ray.state & RayRecord::kInLeaf) {
          finished.Prefetch(task.rays[i + kFetchHits]);
          finished.Add(static_cast<RayNumber>(i));
          if (finished.count() == FinishedHits::kMost) finish();
        } else {
          layout.WriteHit(caller_of(i), task.hits[i]);
        }
      }
      ++stored;
    }
  }
  finish();
  return stored;
}

/// Rays `first` to `first + count` of the view, in the memory of a workspace or on the stack.
template <Query kQuery>
void TraceView(const SceneParts& scene, const RayView& view, size_t first, size_t count,
               const CallOptions& options, SplitMemory& split_memory, RayRecord* rays,
               FullHit* hits, uint32_t* callers, const InstanceMemory& instance_memory,
               ListMemory lists, Statistics* statistics) {
  const LoadedRays loaded = LoadRecords(view, first, count, rays, callers);
  if (statistics) {
    statistics->rays += loaded.count;
    ++statistics->pieces;
  }
  if (loaded.count == 0) return;
  const CallFrame frame{&view, first, options, view.instance_value};
  const TraceTask task{scene,
                       scene.partition(),
                       rays,
                       hits,
                       !scene.meshes.AllAccept(loaded.common_mask),
                       !scene.meshes.shapes().has_filters(),
                       frame,
                       split_memory,
                       instance_memory,
                       statistics,
                       FinishHit,
                       view.instance_value,
                       callers};
  TraceLoaded<kQuery>(task, loaded, lists);
  const size_t stored = StoreRecords<kQuery>(task, loaded);
  if (statistics) statistics->hits += stored;
}

template <Query kQuery>
void TracePieceFor(const SceneParts& scene, const RayView& view, size_t first, size_t count,
                   const CallOptions& options, Workspace& workspace, Statistics& statistics) {
  SplitMemory split_memory(workspace.scratch().subset);
  TraceView<kQuery>(scene, view, first, count, options, split_memory, workspace.rays(),
                    workspace.hits(), workspace.callers(), workspace.instance_memory(),
                    workspace.lists(), &statistics);
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
  SplitMemory split_memory(pool);
  TraceView<kQuery>(scene, view, 0, view.count, options, split_memory, memory.rays, memory.hits,
                    memory.numbers, memory.ForInstances(), memory.Lists(), nullptr);
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
  if (packet.valid && *packet.valid != -1) return;
  if (!FinishRecord(ray)) return;
  FullHit hit;
  RayRecord instance_ray;
  FullHit instance_hit;
  uint32_t caller;
  std::optional<RayView> view;  // for callbacks
  if (HWY_UNLIKELY(scene.has_callbacks)) view = ViewOf(packet);
  const CallFrame frame{view ? &*view : nullptr, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  const TraceTask task{scene,
                       scene.partition(),
                       &ray,
                       &hit,
                       !scene.meshes.AllAccept(ray.mask),
                       !scene.meshes.shapes().has_filters(),
                       frame,
                       split_memory,
                       {&instance_ray, &instance_hit, &caller, 1},
                       nullptr,
                       FinishHit,
                       packet.instance_value};
  OneTracer<kQuery>(task).Trace(scene.kept->root(), 0, ListMemory{});
  if constexpr (kQuery == Query::kAny) {
    if (ray.tfar < 0) {
      record[static_cast<size_t>(PacketComponent::kTfar)] =
          -std::numeric_limits<float>::infinity();
    }
  } else {
    if (!(ray.state & RayRecord::kHasHit)) return;
    uint32_t mesh;
    RecordLayout::WriteRecord(task.HitOf(0, mesh), record);
  }
}

/// Lanes of a packet.
template <Query kQuery>
void TraceLanes(const SceneParts& scene, const RayPacket& packet, const CallOptions& options,
                WorkspacePool& pool) {
  StackMemory<kMaxLanes> memory;
  RayView view;
  if (HWY_UNLIKELY(scene.has_callbacks)) view = ViewOf(packet);
  size_t count = 0;
  uint32_t common_mask = UINT32_MAX;
  for (uint32_t lane = 0; lane < packet.lanes; ++lane) {
    if (packet.valid && packet.valid[lane] != -1) continue;
    RayRecord& ray = memory.rays[count];
    RecordLayout::ReadLane(packet, lane, ray);
    if (!FinishRecord(ray)) continue;
    common_mask &= ray.mask;
    memory.numbers[count++] = lane;
  }
  if (count == 0) return;
  const CallFrame frame{&view, 0, options, packet.instance_value};
  SplitMemory split_memory(pool);
  const TraceTask task{scene,
                       scene.partition(),
                       memory.rays,
                       memory.hits,
                       !scene.meshes.AllAccept(common_mask),
                       !scene.meshes.shapes().has_filters(),
                       frame,
                       split_memory,
                       memory.ForInstances(),
                       nullptr,
                       FinishHit,
                       packet.instance_value,
                       memory.numbers};
  TraceRaysFrom<kQuery>(task, scene.kept->root(), count, memory.Lists());
  FinishedHits finished(task);
  const auto finish = [&]() HWY_ATTR {
    finished.Finish([&](size_t i, const FullHit& hit) HWY_ATTR {
      RecordLayout::WriteLane(packet, memory.numbers[finished.number(i)], hit);
    });
  };
  for (size_t i = 0; i < count; ++i) {
    const RayRecord& ray = memory.rays[i];
    if constexpr (kQuery == Query::kAny) {
      if (ray.tfar < 0) RecordLayout::WriteBlocked(packet, memory.numbers[i]);
    } else if (ray.state & RayRecord::kInLeaf) {
      finished.Add(static_cast<RayNumber>(i));
      if (finished.count() == FinishedHits::kMost) finish();
    } else if (ray.state & RayRecord::kHasHit) {
      RecordLayout::WriteLane(packet, memory.numbers[i], memory.hits[i]);
    }
  }
  finish();
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
