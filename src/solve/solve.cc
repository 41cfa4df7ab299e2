#include "solve/solve.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "solve/solve.cc"
#include <hwy/foreach_target.h>

#include "partition/list_triangles-inl.h"
#include "query/query_point-inl.h"
#include "rays/store_hits-inl.h"
#include "solve/solve_kept-inl.h"
#include "solve/solve_objects-inl.h"
#include "solve/solve_space-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

template <Query kQuery>
void SolveFor(const SolveTask& task, const TriangleRange& triangles, const RayBlock& rays) {
  if (task.kept) {
    KeptSolver<kQuery>(task).Solve(rays);
  } else if (task.settings.algorithm == Algorithm::kMora2011 && !task.frame) {
    SpaceSolver<kQuery>(task).Solve(triangles, rays);
  } else {
    ObjectSolver<kQuery>(task).Solve(triangles, rays, 1);
  }
}

void SolvePiece(Query query, const SolveTask& task, const TriangleRange& triangles,
                const RayBlock& rays) {
  if (query == Query::kClosest) {
    SolveFor<Query::kClosest>(task, triangles, rays);
  } else {
    SolveFor<Query::kAny>(task, triangles, rays);
  }
}

size_t StorePiece(Query query, const RayView& view, size_t first, const SolveTask& task,
                  const RayBlock& rays) {
  if (query == Query::kAny) return StoreBlocked(view, first, task.batch, rays);
  if (task.frame) return StoreFullHits(view, first, task.batch, rays);
  return StoreClosest(view, first, task.meshes, task.batch, rays, task.scratch.triangles);
}

void SplitAll(KeptPartition& kept, SubsetScratch& scratch, TaskPool& tasks) {
  RootOf(kept, 0, scratch, &tasks);
}

void QueryPointIn(PointTask& task, const SceneParts& scene) {
  PointWalk(task, scene, task.query.to_scene, nullptr).Walk();
}

}  // namespace

const Kernels* GetKernels() {
  static constexpr Kernels kKernels{SolvePiece, ListTriangles, SplitAll, StorePiece, QueryPointIn};
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {
namespace {

HWY_EXPORT(GetKernels);

struct Target {
  InstructionSet instruction_set;
  int64_t bits;  ///< Highway's targets that make it up
};

// Worst first. Highway's portable code is one of two, by compiler; both are called scalar here.
constexpr Target kTargets[] = {
    {InstructionSet::kScalar, HWY_SCALAR | HWY_EMU128},
    {InstructionSet::kSsse3, HWY_SSSE3},
    {InstructionSet::kSse4, HWY_SSE4},
    {InstructionSet::kAvx2, HWY_AVX2},
    {InstructionSet::kAvx512, HWY_AVX3 | HWY_AVX3_DL},
};

/// What this build can run on this processor; its portable code always.
int64_t TargetsHere() { return (hwy::SupportedTargets() & HWY_TARGETS) | HWY_STATIC_TARGET; }

}  // namespace

std::vector<InstructionSet> AvailableInstructionSets() {
  std::vector<InstructionSet> available;
  for (const Target& target : kTargets) {
    if (target.bits & TargetsHere()) {
      available.push_back(target.instruction_set);
    }
  }
  return available;
}

const Kernels& ChooseKernels(InstructionSet limit, InstructionSet& chosen) {
  int64_t allowed = 0;
  for (const Target& target : kTargets) {
    if (!(target.bits & TargetsHere())) continue;
    // The worst one is taken even if the limit is below it: the code has no worse one.
    if (allowed != 0 && target.instruction_set > limit) continue;
    allowed |= target.bits & TargetsHere();
    chosen = target.instruction_set;
  }
  hwy::ChosenTarget target;
  target.Update(allowed);
  return *HWY_DISPATCH_TABLE(GetKernels)[target.GetIndex()]();
}

}  // namespace dacrt
#endif  // HWY_ONCE
