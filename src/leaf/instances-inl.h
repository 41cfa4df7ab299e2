// The leaf test of instances: the rays that enter one go down its scene as a list of their own.

#if defined(DACRT_LEAF_INSTANCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_INSTANCES_INL_H_
#undef DACRT_LEAF_INSTANCES_INL_H_
#else
#define DACRT_LEAF_INSTANCES_INL_H_
#endif

#include <hwy/cache_control.h>

#include <algorithm>
#include <cstdint>

#include "leaf/entering-inl.h"
#include "leaf/finish_hit-inl.h"
#include "leaf/instance_leaf.h"
#include "leaf/instance_transform-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Traces rays 0 to count - 1 of a task (see trace/trace_rays-inl.h).
template <Query kQuery>
void TraceRays(const TraceTask& task, size_t count, ListMemory memory);
/// The same from a root on.
template <Query kQuery>
void TraceRaysFrom(const TraceTask& task, ChildWord root, size_t count, ListMemory memory);

/// What rays find in an instance that shows `scene`, that are `numbers` of the task outside.
inline TraceTask TaskInInstance(const TraceTask& outer, uint32_t geometry, const SceneParts& scene,
                                const PartitionView& partition, const RayNumber* numbers) {
  const InstanceMemory& memory = outer.instance_memory;
  return {scene,
          partition,
          memory.rays,
          memory.hits,
          outer.checks_masks,
          /*keeps_leaf_hits=*/true,
          outer.frame,
          outer.split_memory,
          InstanceMemory{},
          outer.statistics,
          outer.finish_hit,
          outer.scene.geometries[geometry].geometry_id,
          /*callers=*/nullptr,
          &outer,
          numbers,
          outer.any_hit_order};
}

/// Fetches what rays begin with in the scene of an instance, all at once.
HWY_INLINE void FetchScene(const InstanceLeaf& leaf) {
  hwy::Prefetch(leaf.all);
  // Most begin with the first node; by its address, since what is hidden has none.
  const auto node = reinterpret_cast<std::uintptr_t>(leaf.partition.nodes);
  hwy::Prefetch(reinterpret_cast<const std::byte*>(node));
  hwy::Prefetch(reinterpret_cast<const std::byte*>(node + 64));
  hwy::Prefetch(leaf.scene);
}

/// Rays in the space of an instance.
template <Query kQuery>
class InstanceRays {
 public:
  /// Of the instance in a block, which must stay in place.
  InstanceRays(const TraceTask& task, const LeafBlock& block, uint32_t geometry, ListMemory memory)
      : task_(task),
        geometry_(geometry),
        memory_(memory),
        inner_(task.instance_memory),
        still_(block.is_timed ? nullptr : &InstanceLeaf::In(block)) {
    if (HWY_LIKELY(still_ != nullptr)) transform_.Set(still_->to_instance);
  }

  void Add(RayNumber number) {
    const RayRecord& outer = task_.rays[number];
    if (HWY_UNLIKELY(!still_) && (count_ == 0 || outer.time != time_)) {
      time_ = outer.time;
      transform_.Set(task_.scene.geometries.shapes().ToInstance(geometry_, time_));
    }
    RayRecord& ray = inner_.rays[count_];
    transform_.Apply(outer, ray);
    if (ray.state & RayRecord::kHasHit) ray.state |= RayRecord::kOfOuter;
    inner_.outer_rays[count_] = number;
    if (++count_ == inner_.count) Trace();
  }

  void Trace() {
    if (count_ == 0) return;
    const SceneParts& scene =
        still_ ? *still_->scene : *task_.scene.geometries.shapes().InstancedScene(geometry_);
    const TraceTask task = TaskInInstance(
        task_, geometry_, scene, still_ ? still_->partition : scene.partition(), inner_.outer_rays);
    if (HWY_LIKELY(still_ && still_->all)) {
      TraceRaysFrom<kQuery>(task, still_->Root(), count_, memory_);
    } else {
      TraceRays<kQuery>(task, count_, memory_);
    }
    FinishedHits finished(task);
    const auto finish = [&]() HWY_ATTR {
      finished.Finish([&](size_t i, uint32_t geometry, const FullHit& hit)
                          HWY_ATTR { Take(finished.number(i), geometry, hit); });
    };
    for (size_t i = 0; i < count_; ++i) {
      const RayRecord& ray = inner_.rays[i];
      RayRecord& outer = task_.rays[inner_.outer_rays[i]];
      outer.tfar = std::min(outer.tfar, ray.tfar);
      constexpr uint32_t kWhose = RayRecord::kHasHit | RayRecord::kOfOuter;
      if (kQuery == Query::kAny || (ray.state & kWhose) != RayRecord::kHasHit) continue;
      if (!(ray.state & RayRecord::kInLeaf)) {
        Take(i, ray.hit, inner_.hits[i]);
      } else {
        finished.Add(static_cast<RayNumber>(i));
        if (finished.count() == FinishedHits::kMost) finish();
      }
    }
    if (finished.count() > 0) finish();
    count_ = 0;
  }

 private:
  /// Gives an outer ray the hit that it has in the instance.
  void Take(size_t i, uint32_t geometry, const FullHit& hit) const {
    RayRecord& outer = task_.rays[inner_.outer_rays[i]];
    outer.state = RayRecord::kHasHit | (inner_.rays[i].state & RayRecord::kAtLimit);
    outer.hit = geometry;
    task_.hits[inner_.outer_rays[i]] = hit;
  }

  const TraceTask& task_;
  const uint32_t geometry_;
  const ListMemory memory_;
  const InstanceMemory& inner_;
  const InstanceLeaf* const still_;  ///< null if the instance moves
  InstanceTransform transform_;
  float time_ = 0;
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_INSTANCES_INL_H_
