// User primitives and instances that do not move against the rays of a group.

#if defined(DACRT_TRACE_GROUP_ITEMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_ITEMS_INL_H_
#undef DACRT_TRACE_GROUP_ITEMS_INL_H_
#else
#define DACRT_TRACE_GROUP_ITEMS_INL_H_
#endif

#include <algorithm>

#include "leaf/user.h"
#include "trace/group_instances-inl.h"
#include "trace/policy.h"
#include "trace/ray_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <Query kQuery, size_t kMost>
class GroupItems {
 public:
  explicit GroupItems(RayGroup<kMost>& rays)
      : rays_(rays), task_(rays.task()), lanes_(rays.lanes()) {}

  /// Hands the rays of some lanes to the functions of user primitives.
  HWY_NOINLINE void TestUserPrimitives(const LeafBlock& block, LaneMask active) {
    for (size_t i = 0; i < block.lanes; ++i) {
      const GeometryTable::Name item = NameOfLane(task_, block, i);
      const Geometry& user = task_.scene.geometries.shapes()[item.geometry];
      const Callback& function = UserFunctionOf(kQuery, user);
      const LaneMask entering = EnterItem(lanes_, block, i, active);
      if (entering == 0 || !function) continue;
      GroupHits<kMost> hits;
      if constexpr (kQuery == Query::kClosest) hits = GroupHits<kMost>(task_, lanes_, active);
      hits.SetNone();
      typename GroupPackets<kMost>::Answers answers;
      rays_.Packets().Call(function, kQuery, item, entering, lanes_.tfar, hits, answers);
      ForEachLane(answers.changed, [&](size_t lane) {
        const FullHit& hit = answers.hits[lane];
        if constexpr (kQuery == Query::kAny) {
          if (hit.t < 0) lanes_.tfar[lane] = hit.t;
          return;
        }
        lanes_.state[lane] = RayRecord::kHasHit;
        lanes_.hit[lane] = item.geometry;
        lanes_.tfar[lane] = std::min(lanes_.tfar[lane], hit.t);
        task_.hits[lane] = hit;
      });
    }
  }

  /// The instance in a block, which does not move.
  void TestInstances(const LeafBlock& block, LaneMask active, ListMemory memory) {
    if (task_.instance_memory.count == 0) return;  // There is one level of instances.
    const InstanceLeaf& leaf = InstanceLeaf::In(block);
    FetchScene(leaf);
    const LaneMask entering = EnterItem(lanes_, block, 0, active);
    if (entering == 0) return;
    if (hwy::PopCount(entering) > policy::kFewRays &&
        GroupInInstance<kQuery, kMost>::CanBe(task_, leaf, lanes_.parts())) {
      return TraceInInstance(leaf, block.geometry, entering, memory);
    }
    InstanceRays<kQuery> rays(task_, block, block.geometry, memory);
    ForEachLane(entering, [&](size_t lane) {
      rays_.RecordOf(lane);
      rays.Add(rays_.numbers()[lane]);
    });
    rays.Trace();
    rays_.LoadHits(entering);
  }

 private:
  void TraceInInstance(const InstanceLeaf& leaf, uint32_t geometry, LaneMask entering,
                       ListMemory memory) {
    GroupLanes<kMost> inner;
    TransformLanes(leaf.to_instance, lanes_, inner);
    // The name of a hit of this scene is asked of its record.
    ForEachLane(lanes_.LanesInState(entering, RayRecord::kInLeaf),
                [&](size_t lane) { rays_.RecordOf(lane); });
    GroupInInstance<kQuery, kMost>(task_, leaf, geometry, rays_.numbers())
        .Trace(lanes_, inner, entering, memory);
  }

  RayGroup<kMost>& rays_;
  const TraceTask& task_;
  GroupLanes<kMost>& lanes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_ITEMS_INL_H_
