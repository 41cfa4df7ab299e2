// The leaf test of instances: the rays that enter one go down its scene as a list of their own.

#if defined(DACRT_LEAF_INSTANCES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_LEAF_INSTANCES_INL_H_
#undef DACRT_LEAF_INSTANCES_INL_H_
#else
#define DACRT_LEAF_INSTANCES_INL_H_
#endif

#include <algorithm>
#include <cmath>

#include "leaf/entering-inl.h"
#include "leaf/finish_hit-inl.h"
#include "rays/load_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Traces rays 0 to count - 1 of a task (see trace/trace_rays-inl.h).
template <Query kQuery>
void TraceRays(const TraceTask& task, size_t count, ListMemory memory);

/// Rays in the space of an instance.
template <Query kQuery>
class InstanceRays {
 public:
  InstanceRays(const TraceTask& task, uint32_t geometry, ListMemory memory)
      : task_(task),
        geometry_(geometry),
        scene_(*task.scene.geometries.shapes().InstancedScene(geometry)),
        memory_(memory),
        inner_(task.instance_memory) {
    const Shapes& shapes = task.scene.geometries.shapes();
    is_moving_ = shapes.IsMoving(geometry);
    SetTransform(shapes.ToInstance(geometry, 0));
  }

  void Add(RayNumber number) {
    const RayRecord& outer = task_.rays[number];
    if (is_moving_ && (count_ == 0 || outer.time != time_)) {
      time_ = outer.time;
      SetTransform(task_.scene.geometries.shapes().ToInstance(geometry_, time_));
    }
    RayRecord& ray = inner_.rays[count_];
    Transform(outer, ray);
    if (HasFullHit(ray)) inner_.hits[count_] = task_.hits[number];
    if (ray.state & RayRecord::kInLeaf) ray.state |= RayRecord::kOfOuter;
    outer_[count_] = number;
    inner_.callers[count_] = task_.CallerOf(number);
    if (++count_ == inner_.count) Trace();
  }

  void Trace() {
    if (count_ == 0) return;
    const TraceTask task{scene_,
                         scene_.partition(),
                         inner_.rays,
                         inner_.hits,
                         task_.checks_masks,
                         /*keeps_leaf_hits=*/true,
                         task_.frame,
                         task_.split_memory,
                         {nullptr, nullptr, nullptr, 0},
                         task_.statistics,
                         task_.finish_hit,
                         task_.scene.geometries[geometry_].geometry_id,
                         inner_.callers,
                         &task_,
                         outer_,
                         task_.any_hit_order};
    TraceRays<kQuery>(task, count_, memory_);
    FinishedHits finished(task);
    const auto finish = [&]() HWY_ATTR {
      finished.Finish([&](size_t i, const FullHit& hit)
                          HWY_ATTR { Take(finished.number(i), finished.geometry(i), hit); });
    };
    for (size_t i = 0; i < count_; ++i) {
      const RayRecord& ray = inner_.rays[i];
      RayRecord& outer = task_.rays[outer_[i]];
      outer.tfar = std::min(outer.tfar, ray.tfar);
      if (kQuery == Query::kAny || !(ray.state & RayRecord::kHasHit)) continue;
      if (!(ray.state & RayRecord::kInLeaf)) {
        Take(i, ray.hit, inner_.hits[i]);
      } else if (!(ray.state & RayRecord::kOfOuter)) {
        finished.Add(static_cast<RayNumber>(i));
        if (finished.count() == FinishedHits::kMost) finish();
      }
    }
    if (finished.count() > 0) finish();
    count_ = 0;
  }

 private:
  /// One that is known by leaf and lane is not of this instance.
  static bool HasFullHit(const RayRecord& ray) {
    return kQuery == Query::kClosest &&
           (ray.state & (RayRecord::kHasHit | RayRecord::kInLeaf)) == RayRecord::kHasHit;
  }

  /// Gives an outer ray the hit that it has in the instance.
  void Take(size_t i, uint32_t geometry, const FullHit& hit) const {
    RayRecord& outer = task_.rays[outer_[i]];
    outer.state = RayRecord::kHasHit | (inner_.rays[i].state & RayRecord::kAtLimit);
    outer.hit = geometry;
    task_.hits[outer_[i]] = hit;
  }

  void SetTransform(const AffineTransform& transform) {
    for (int i = 0; i < 4; ++i) std::copy_n(transform.column[i], 3, columns_[i]);
  }

#if HWY_NATIVE_FMA && HWY_TARGET != HWY_SCALAR
  /// Writes a ray as it is in the instance. By vectors: what is stored in parts cannot be loaded as
  /// a whole soon after.
  HWY_INLINE void Transform(const RayRecord& outer, RayRecord& ray) const {
    static_assert(kCornerParts == 1);
    ray = outer;
    const auto xyz = hn::FirstN(kCornerTag, 3);
    const auto map = [&](const float* vector, CornerPart value) HWY_ATTR {
      for (int i = 2; i >= 0; --i) {
        value =
            hn::MulAdd(hn::Set(kCornerTag, vector[i]), hn::Load(kCornerTag, columns_[i]), value);
      }
      return value;
    };
    // What stands behind each three values stays.
    const auto put = [&](CornerPart value, const float* before, float* out) HWY_ATTR {
      hn::Store(hn::IfThenElse(xyz, value, hn::Load(kCornerTag, before)), kCornerTag, out);
    };
    const auto dir = map(outer.dir, hn::Zero(kCornerTag));
    put(map(outer.org, hn::Load(kCornerTag, columns_[3])), outer.org, ray.org);
    put(dir, outer.dir, ray.dir);
    put(SafeReciprocal(dir), outer.reciprocal, ray.reciprocal);
  }
#else
  void Transform(const RayRecord& outer, RayRecord& ray) const {
    ray = outer;
    for (int axis = 0; axis < 3; ++axis) {
      float org = columns_[3][axis], dir = 0;
      for (int i = 2; i >= 0; --i) {
        org = std::fma(outer.org[i], columns_[i][axis], org);
        dir = std::fma(outer.dir[i], columns_[i][axis], dir);
      }
      ray.org[axis] = org;
      ray.dir[axis] = dir;
    }
    SetReciprocals(ray);
  }
#endif

  const TraceTask& task_;
  const uint32_t geometry_;
  const SceneParts& scene_;
  const ListMemory memory_;
  const InstanceMemory& inner_;
  HWY_ALIGN float columns_[4][4] = {};
  bool is_moving_;
  float time_ = 0;
  RayNumber outer_[InstanceMemory::kRays];
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_LEAF_INSTANCES_INL_H_
