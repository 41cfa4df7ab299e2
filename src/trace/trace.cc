#include "trace/trace.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "trace/trace.cc"
#include <hwy/foreach_target.h>

#include "trace/stack_memory.h"
#include "trace/trace_packet-inl.h"
#include "trace/trace_view-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

template <Query kQuery>
void TracePieceFor(const SceneParts& scene, const RayView& view, size_t first, size_t count,
                   const CallOptions& options, Workspace& workspace, Statistics& statistics) {
  SplitMemory split_memory(workspace.scratch().subset);
  TraceView<kQuery>(scene, view, first, count, options, split_memory, workspace.rays(),
                    workspace.hits(), workspace.callers(), workspace.instance_memory(),
                    workspace.lists(), workspace.tags(), &statistics);
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
                    memory.numbers, memory.ForInstances(), memory.Lists(), nullptr, nullptr);
}

void TraceShort(Query query, const SceneParts& scene, const RayView& view,
                const CallOptions& options, WorkspacePool& pool) {
  if (query == Query::kClosest) {
    TraceShortFor<Query::kClosest>(scene, view, options, pool);
  } else {
    TraceShortFor<Query::kAny>(scene, view, options, pool);
  }
}

}  // namespace

const TraceKernels* GetTraceKernels() {
  static constexpr TraceKernels kKernels{TracePiece,
                                         TraceShort,
                                         {TraceSingle<Query::kClosest>, TraceSingle<Query::kAny>},
                                         {TraceLanes<Query::kClosest>, TraceLanes<Query::kAny>}};
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
