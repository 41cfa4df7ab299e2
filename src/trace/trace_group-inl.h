// A group of up to 64 neighbouring rays in the lanes of vectors, each still looking or not by a
// lane mask: for rays that run close together, which enter the same children.
//
// Wald, Slusallek, Benthin, Wagner, "Interactive rendering with coherent ray tracing", Eurographics
// 2001; intervals over a group that leave out children for all of its rays at once: Reshetov,
// Soupikov, Hurley, "Multi-level ray tracing algorithm", SIGGRAPH 2005.

#if defined(DACRT_TRACE_TRACE_GROUP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_TRACE_GROUP_INL_H_
#undef DACRT_TRACE_TRACE_GROUP_INL_H_
#else
#define DACRT_TRACE_TRACE_GROUP_INL_H_
#endif

#include <algorithm>
#include <optional>

#include "trace/enter_group-inl.h"
#include "trace/group_leaf-inl.h"
#include "trace/learnt.h"
#include "trace/policy.h"
#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Nodes and leaves that a group has visited, and with how many lanes, those of all visits
/// together.
struct GroupVisits {
  uint32_t count = 0;
  uint32_t lanes = 0;
};

template <Query kQuery, size_t kMost>
class GroupTracer {
 public:
  GroupTracer(const TraceTask& task, GroupLanes<kMost>& lanes)
      : task_(task), lanes_(lanes), rays_(task, lanes), leaves_(rays_) {}

  const GroupVisits& visits() const { return visits_; }

  /// The rays of some lanes, which the caller has loaded. One that needs a record of its own gets
  /// task.rays[lane].
  void TraceLanes(ChildWord root, LaneMask active, ListMemory memory) {
    rays_.BeginLanes(active);
    TraceActive(root, active, memory);
  }

  /// The rays `numbers[0]` to `numbers[count - 1]` of the task, at most kMost.
  void TraceRecords(ChildWord root, const RayNumber* numbers, size_t count, ListMemory memory) {
    rays_.BeginRecords(numbers, count);
    TraceActive(root, FirstLanes(count), memory);
    for (size_t lane = 0; lane < count; ++lane) {
      RayRecord& ray = task_.rays[numbers[lane]];
      lanes_.StoreHit(lane, ray);
      ray.state &= ~RayRecord::kInLanes;
    }
  }

 private:
  void TraceActive(ChildWord root, LaneMask active, ListMemory memory) {
    uint32_t octant;
    if (lanes_.LanesOfOctant(active, octant) == active) {
      const GroupInterval interval(lanes_, active, octant);
      if (interval.IsNarrow(task_.scene.bounds.LongestSide())) {
        return Walk(root, active, memory,
                    TogetherEnter<kMost>{task_, lanes_, kPlaneOffsets[octant], interval});
      }
    }
    Walk(root, active, memory, EachEnters<kMost>{task_, lanes_});
  }

  static constexpr size_t kMostOpen = 256;

  /// `enter` opens the children of a node that active lanes enter.
  template <class Enter>
  void Walk(ChildWord child, LaneMask active, ListMemory memory, const Enter& enter) {
    OpenForLanes open[kMostOpen];
    size_t count = 0;
    for (;;) {
      const auto lanes = static_cast<uint32_t>(hwy::PopCount(active));
      ++visits_.count;
      visits_.lanes += lanes;
      if (child.IsLeaf()) {
        leaves_.Test(child, active, memory, enter);
      } else if (lanes <= Enter::kFewRays || HWY_UNLIKELY(count + WideNode::kWidth > kMostOpen)) {
        visits_.count += policy::kVisitsAlone * lanes;
        visits_.lanes += policy::kVisitsAlone * lanes;
        TraceFew(child, active, memory);
      } else if (HWY_UNLIKELY(child.IsSubset())) {
        const auto walk = [&](ChildWord node) { Walk(node, active, memory, enter); };
        if (const auto opened = OpenForGroup(child.number(), active, memory, walk)) {
          child = *opened;
          continue;
        }
      } else {
        const size_t bottom = count;
        enter(task_.partition.nodes[child.number()], active, open, count);
        const ChildOrder order =
            kQuery == Query::kAny ? task_.any_hit_order : ChildOrder::kNearestFirst;
        if (order != ChildOrder::kAsStored) SortNearestLast(open, bottom, count);
        if (order != ChildOrder::kNearestFirst) std::reverse(open + bottom, open + count);
      }
      do {
        if (count == 0) return;
        --count;
        active = lanes_.WithEndsFrom(open[count].distance, open[count].lanes);
      } while (active == 0);
      child = ChildWord(open[count].word);
    }
  }

  /// The rays of some lanes, each in its own way; apart, so that the walk of groups stays short.
  HWY_NOINLINE void TraceFew(ChildWord child, LaneMask active, ListMemory memory) {
    rays_.TestRecords(active, [&](const RayNumber* list, size_t count) {
      OneTracer<kQuery>(task_).TraceAll(child, list, count, memory);
    });
  }

  /// OpenSubset for the rays of some lanes, which `walk(node)` traces from a node on.
  template <class WalkFrom>
  std::optional<ChildWord> OpenForGroup(uint32_t subset, LaneMask active, ListMemory memory,
                                        const WalkFrom& walk) {
    const auto with_list = [&](const auto& with) { rays_.TestRecords(active, with); };
    const auto trace_list = [&](const TraceTask& own, ChildWord node) {
      ForEachLane(active, [&](size_t lane) {
        OneTracer<kQuery>(own).Trace(node, rays_.numbers()[lane], memory);
      });
    };
    return OpenSubset<kQuery>(task_, subset, hwy::PopCount(active), memory, with_list, walk,
                              trace_list);
  }

  const TraceTask& task_;
  GroupLanes<kMost>& lanes_;
  RayGroup<kMost> rays_;
  GroupLeafTest<kQuery, kMost> leaves_;
  GroupVisits visits_;
};

/// What any-hit groups of a scene have learnt, or packets; null for closest hits, whose order is
/// known.
template <Query kQuery>
HWY_INLINE LearntOrder* LearntOfGroups(const SceneParts& scene, LearntOrder Learnt::*whose) {
  return kQuery == Query::kAny ? &(LearntAbout(scene.kept.get()).*whose) : nullptr;
}

/// The rays of some lanes, from the root on, in the order that was learnt; which learns from them.
template <Query kQuery, size_t kMost>
HWY_INLINE GroupVisits TraceGroup(TraceTask& task, GroupLanes<kMost>& lanes, LaneMask active,
                                  ListMemory memory, LearntOrder* learnt) {
  if constexpr (kQuery == Query::kAny) task.any_hit_order = learnt->Next();
  GroupTracer<kQuery, kMost> tracer(task, lanes);
  tracer.TraceLanes(task.scene.kept->root(), active, memory);
  if constexpr (kQuery == Query::kAny) learnt->Count(tracer.visits().count);
  return tracer.visits();
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_TRACE_GROUP_INL_H_
