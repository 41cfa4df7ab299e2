#include "paper/paper.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "paper/paper.cc"
#include <hwy/foreach_target.h>

#include "paper/solve_objects-inl.h"
#include "paper/solve_space-inl.h"
#include "paper/store_hits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

template <Query kQuery>
void SolveFor(const PaperTask& task, const TriangleRange& triangles, const RayBlock& rays) {
  if (task.settings.algorithm == Algorithm::kMora2011 && task.scene.geometries.is_plain()) {
    SpaceSolver<kQuery>(task).Solve(triangles, rays);
  } else {
    ObjectSolver<kQuery>(task).Solve(triangles, rays, 1);
  }
}

void Solve(Query query, const PaperTask& task, const TriangleRange& triangles,
           const RayBlock& rays) {
  if (query == Query::kClosest) {
    SolveFor<Query::kClosest>(task, triangles, rays);
  } else {
    SolveFor<Query::kAny>(task, triangles, rays);
  }
}

size_t Store(Query query, const RayView& view, size_t first, const PaperTask& task,
             const RayBlock& rays) {
  if (query == Query::kAny) return StoreBlocked(view, first, task.batch, rays);
  if (!task.scene.geometries.is_plain()) return StoreFullHits(view, first, task.batch, rays);
  return StoreClosest(view, first, task.scene.geometries, task.batch, rays, task.scratch.triangles);
}

}  // namespace

const PaperKernels* GetPaperKernels() {
  static constexpr PaperKernels kKernels{Solve, Store};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {
HWY_EXPORT(GetPaperKernels);
}  // namespace

const PaperKernels& PaperKernelsFor(std::size_t target) {
  return *HWY_DISPATCH_TABLE(GetPaperKernels)[target]();
}

}  // namespace dacrt
#endif  // HWY_ONCE
