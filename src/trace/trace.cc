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

/// How rays go that have next to nothing in common: as groups where a group can test each of them
/// against all children at once. Calls of 64 rays by lists and as groups, with AVX2 only (Zen 3):
/// ambient rays 476 and 333 ns a ray in Sponza, 167 and 108 in the kitchen, diffuse ones 823 and
/// 691, 422 and 331. With AVX-512 (Sapphire Rapids), of seven scenes in the mean: ambient rays .77,
/// diffuse ones .89, shadow rays .87 times as long. Of larger calls lists are quicker in some
/// scenes, groups in others, so that is learnt.
constexpr bool kHasGroupsApart = kParts == 1;

/// Of a short call lists are too short to pay for themselves: with SSE4.2 (Zen 1) 32 and 256
/// diffuse rays with a filter function took 2,102 and 1,731 ns a ray in a hall by lists, 1,288 and
/// 1,241 alone, ambient ones in the kitchen 456 and 299, 269 and 272.
constexpr Walk kShortApart = kHasGroupsApart ? Walk::kLargestGroups : Walk::kAlone;

template <Query kQuery>
void TracePieceFor(const SceneParts& scene, const RayView& view, size_t first, size_t count,
                   const CallOptions& options, Workspace& workspace, Statistics& statistics) {
  SplitMemory split_memory(workspace.scratch().subset);
  const auto trace = [&](size_t begin, size_t rays, Walk walk) {
    TraceView<kQuery>(scene, view, first + begin, rays, walk, options, split_memory,
                      workspace.rays(), workspace.hits(), workspace.callers(),
                      workspace.instance_memory(), workspace.lists(), workspace.tags(),
                      &statistics);
  };
  if (GoTogether(scene, RecordLayout(view), first, count)) return trace(0, count, Walk::kGroups);
  if (!kHasGroupsApart) return trace(0, count, Walk::kLists);
  LearntWay& learnt = LearntAbout(scene.kept.get()).ApartInPiece(kQuery, count);
  for (size_t done = 0; done < count;) {
    const size_t rays = HWY_MIN(count - done, learnt.MostRays());
    learnt.Trace(
        static_cast<uint32_t>(rays), [&] { trace(done, rays, Walk::kLists); },
        [&] { trace(done, rays, Walk::kLargestGroups); });
    done += rays;
  }
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

bool RunTogether(const SceneParts& scene, const RayView& view) {
  return GoTogether(scene, RecordLayout(view), 0, view.count);
}

/// In memory on the stack; apart, so that rays that go alone do without.
template <Query kQuery>
HWY_NOINLINE void TraceOnStack(const SceneParts& scene, const RayView& view, Walk walk,
                               const CallOptions& options, WorkspacePool& pool) {
  StackMemory<policy::kShortCall> memory;
  SplitMemory split_memory(pool);
  TraceView<kQuery>(scene, view, 0, view.count, walk, options, split_memory, memory.rays,
                    memory.hits, memory.numbers, memory.ForInstances(), memory.Lists(), nullptr,
                    nullptr);
}

/// Each ray as if it were a call.
template <Query kQuery>
HWY_INLINE void TraceSingles(const SceneParts& scene, const RayView& view,
                             const RecordLayout& layout, const CallOptions& options,
                             WorkspacePool& pool) {
  RayPacket packet{nullptr, 1, nullptr, view.instance_value, layout.has_masks()};
  for (size_t i = 0; i < view.count; ++i) {
    packet.values = layout.Record(i);
    TraceSingle<kQuery>(scene, packet, options, pool);
  }
}

template <Query kQuery>
void TraceShortFor(const SceneParts& scene, const RayView& view, const CallOptions& options,
                   WorkspacePool& pool) {
  const RecordLayout layout(view);
  const bool together = GoTogether(scene, layout, 0, view.count);
  const auto on_stack = [&](Walk walk) { TraceOnStack<kQuery>(scene, view, walk, options, pool); };
  if (scene.has_callbacks) return on_stack(together ? Walk::kGroups : kShortApart);
  const auto apart = [&] { on_stack(kShortApart); };
  // Looked up where it is wanted only: that costs a short call something.
  const auto learnt = [&]() -> Learnt::OfQuery& {
    return LearntAbout(scene.kept.get()).Of(kQuery);
  };
  const auto count = static_cast<uint32_t>(view.count);
  if (together) {
    const auto as_groups = [&] { on_stack(Walk::kGroups); };
    // Closest hits are quicker as groups, and so is what is soon found.
    if (kQuery == Query::kClosest || scene.is_small) return as_groups();
    return learnt().close.Trace(count, as_groups, apart);
  }
  const bool are_packets =
      kQuery == Query::kClosest ? layout.has_hit_records() : layout.has_records();
  if (!are_packets) return apart();
  learnt().apart.Trace(
      count, [&] { TraceSingles<kQuery>(scene, view, layout, options, pool); }, apart);
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
                                         RunTogether,
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
