// What the recursions share: when to solve directly, filtering a child's rays, counting.

#if defined(DACRT_PAPER_SOLVER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_SOLVER_INL_H_
#undef DACRT_PAPER_SOLVER_INL_H_
#else
#define DACRT_PAPER_SOLVER_INL_H_
#endif

#include <algorithm>
#include <optional>
#include <span>

#include "paper/choose_split-inl.h"
#include "partition/partition_triangles-inl.h"
#include "paper/sample_rays-inl.h"
#include "paper/direct_solve-inl.h"
#include "paper/filter_rays-inl.h"
#include "paper/solve_items-inl.h"
#include "paper/paper_task.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Levels below which triangles are split by bins. Deeper ones are halved by count, so the depth is
/// at most this plus log2 of the number of triangles.
constexpr size_t kMaxBinnedDepth = 64;

/// Sample rays that decide order and skipping where the cost is not sampled: a vector of them.
constexpr size_t kFewSampleRays = 16;

template <Query kQuery>
class Solver {
 public:
  explicit Solver(const PaperTask& task) : task_(task) {}

 protected:
  bool IsLeaf(const TriangleRange& triangles) const {
    return triangles.count() <= task_.settings.leaf_triangles;
  }

  /// Enters a subproblem. True if it is to be solved directly.
  bool IsDirect(const TriangleRange& triangles, const RayBlock& rays, size_t depth) const {
    ++task_.statistics.subproblems;
    task_.statistics.max_depth = std::max<uint64_t>(task_.statistics.max_depth, depth);
    return IsLeaf(triangles) || rays.count <= task_.settings.leaf_rays;
  }

  void SolveDirectly(const TriangleRange& triangles, const RayBlock& rays) const {
    const StepClock::Charge charge(task_.clock, Step::kDirect);
    if (task_.scene.geometries.is_plain()) {
      return SolveDirect<kQuery>(task_, triangles, rays);
    }
    SolveItems<kQuery>(task_, triangles, rays);
  }

  void TakeSamples(const RayBlock& rays, size_t count) const {
    const StepClock::Charge charge(task_.clock, Step::kSampling);
    TakeSampleRays(task_.batch, rays, count, task_.scratch.samples);
  }

  /// Two sides of `triangles` with their references moved, by the best split if there is one.
  Children PartitionObjects(const TriangleRange& triangles, bool sampled, size_t depth) const {
    std::optional<Split> split;
    if (depth <= kMaxBinnedDepth) {
      split = ChooseSplit(task_.refs.data(), triangles, task_.settings.bins, sampled, task_.scratch,
                          task_.clock);
    }
    task_.statistics.median_splits += !split;
    task_.statistics.sampled_splits += split && sampled;
    task_.statistics.sah_splits += split && !sampled;
    const StepClock::Charge charge(task_.clock, Step::kPartition);
    return split ? PartitionTriangles(task_.refs.data(), triangles, *split)
                 : HalveTriangles(task_.refs.data(), triangles);
  }

  /// Filters the rays of `parents` by `bounds`, calls `solve(block)` with those that are left, and
  /// returns their distances. False, and nothing done, if there is no room for them.
  template <class Solve>
  bool WithFilteredRays(std::span<const RayBlock> parents, const Box& bounds,
                        const Solve& solve) const {
    const WideBox box = Widen(bounds.lower, bounds.upper);
    std::optional<FilteredRays> filtered;
    {
      const StepClock::Charge charge(task_.clock, Step::kFiltering);
      filtered = FilterRays(task_.batch, parents, box);
    }
    size_t tested = 0;
    for (const RayBlock& parent : parents) tested += parent.count;
    task_.statistics.box_tests += tested;
    if (!filtered) {
      ++task_.statistics.filters_skipped;
      return false;
    }
    ++task_.statistics.filters;
    task_.statistics.rays_filtered += tested - filtered->block.count;
    if (filtered->block.count > 0) solve(filtered->block);
    const StepClock::Charge charge(task_.clock, Step::kFiltering);
    ReturnDistances(task_.batch, parents, *filtered);
    return true;
  }

  const PaperTask& task_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_SOLVER_INL_H_
