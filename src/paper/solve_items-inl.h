// Direct solve in scenes of more than still triangles: by the leaf tests of src/leaf.

#if defined(DACRT_PAPER_SOLVE_ITEMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_SOLVE_ITEMS_INL_H_
#undef DACRT_PAPER_SOLVE_ITEMS_INL_H_
#else
#define DACRT_PAPER_SOLVE_ITEMS_INL_H_
#endif

#include <algorithm>

#include "paper/paper_task.h"
#include "rays/load_records-inl.h"
#include "trace/stack_memory.h"
#include "trace/trace_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays that are tested at once.
constexpr size_t kItemRays = 64;

/// The ray in a slot of the batch as a record, with the hit that it has.
template <Query kQuery>
inline void MakeRecord(const PaperTask& task, size_t slot, RayRecord& ray, FullHit& hit) {
  const RayBatch& batch = task.batch;
  const uint32_t index = batch.index[slot];
  for (int axis = 0; axis < 3; ++axis) {
    ray.org[axis] = batch.org[axis][slot];
    ray.dir[axis] = batch.dir[axis][slot];
  }
  ray.tnear = batch.tnear[slot];
  ray.start = RayRecord::StartOf(ray.tnear);
  ray.tfar = batch.tfar[slot];
  ray.mask = batch.ray_masks ? batch.ray_masks[index] : UINT32_MAX;
  ray.time = task.frame.Time(index);
  SetReciprocals(ray);
  ray.state = RayRecord::kAtLimit;
  if (kQuery == Query::kAny || batch.hits[index].geometry == PaperHit::kNone) return;
  ray.state = RayRecord::kHasHit;
  if (batch.hits[index].geometry & PaperHit::kAtLimit) ray.state |= RayRecord::kAtLimit;
  ray.hit = batch.hits[index].geometry & ~PaperHit::kAtLimit;
  hit = batch.full_hits[index];
}

/// The way back.
template <Query kQuery>
inline void TakeRecord(const PaperTask& task, size_t slot, const RayRecord& ray,
                       const FullHit& hit) {
  RayBatch& batch = task.batch;
  batch.tfar[slot] = ray.tfar;
  if (kQuery == Query::kAny || !(ray.state & RayRecord::kHasHit)) return;
  const uint32_t index = batch.index[slot];
  batch.hits[index] = {0, ray.state & RayRecord::kAtLimit ? ray.hit | PaperHit::kAtLimit : ray.hit};
  batch.full_hits[index] = hit;
}

/// Tests every ray of `rays` against every item of `triangles`.
template <Query kQuery>
void SolveItems(const PaperTask& task, const TriangleRange& triangles, const RayBlock& rays) {
  ++task.statistics.direct_solves;
  task.statistics.direct_rays += rays.count;
  task.statistics.triangle_tests += rays.count * triangles.count();
  const GeometryTable& geometries = task.scene.geometries;
  StackMemory<kItemRays> memory;
  SplitMemory split_memory(task.scratch.subset);
  uint32_t order[kLeafLanes];
  const TraceTask trace{task.scene,
                        {nullptr, order, nullptr},
                        memory.rays,
                        memory.hits,
                        task.batch.ray_masks != nullptr,
                        /*keeps_leaf_hits=*/false,
                        task.frame,
                        split_memory,
                        memory.ForInstances(),
                        nullptr,
                        FinishHit,
                        task.frame.no_instance,
                        memory.numbers};
  for (size_t first = rays.begin; first < rays.begin + rays.count; first += kItemRays) {
    const size_t count = std::min(kItemRays, rays.begin + rays.count - first);
    RayNumber list[kItemRays];
    for (size_t i = 0; i < count; ++i) {
      MakeRecord<kQuery>(task, first + i, memory.rays[i], memory.hits[i]);
      memory.numbers[i] = task.batch.index[first + i];
      list[i] = static_cast<RayNumber>(i);
    }
    for (size_t begin = triangles.begin; begin < triangles.end; begin += kLeafLanes) {
      const size_t items = std::min(kLeafLanes, triangles.end - begin);
      for (size_t i = 0; i < items; ++i) {
        const TriangleRef& ref = task.refs[begin + i];
        order[i] = geometries.Number(ref.geometry, ref.primitive);
      }
      TestRange<kQuery>(trace, 0, items, list, count, memory.Lists());
    }
    for (size_t i = 0; i < count; ++i) {
      TakeRecord<kQuery>(task, first + i, memory.rays[i], memory.hits[i]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_SOLVE_ITEMS_INL_H_
