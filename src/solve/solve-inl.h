// The recursion: divide-and-conquer ray tracing with ray sampling.
// Nabata, Iwasaki, Dobashi, Nishita, "Efficient Divide-And-Conquer Ray Tracing using Ray Sampling",
// HPG 2013.

#if defined(DACRT_SOLVE_SOLVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_SOLVE_SOLVE_INL_H_
#undef DACRT_SOLVE_SOLVE_INL_H_
#else
#define DACRT_SOLVE_SOLVE_INL_H_
#endif

#include <algorithm>
#include <optional>

#include "partition/choose_split-inl.h"
#include "partition/partition_triangles-inl.h"
#include "partition/split_cost.h"
#include "rays/sample_rays-inl.h"
#include "solve/direct_solve-inl.h"
#include "solve/filter_rays-inl.h"
#include "solve/solve_task.h"

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
  explicit Solver(const SolveTask& task) : task_(task) {}

  void Solve(const TriangleRange& triangles, const RayBlock& rays, size_t depth) const {
    CountSubproblem(depth);
    if (IsDirect(triangles, rays)) return SolveDirect<kQuery>(task_, triangles, rays);
    const bool sampled = SampleActiveRays(rays);
    const Children children = Partition(triangles, sampled, depth);
    for (const Child& child : OrderChildren(children)) {
      if (SkipsFiltering(child)) {
        Solve(*child.triangles, rays, depth + 1);
      } else {
        SolveFiltered(*child.triangles, rays, depth + 1);
      }
    }
  }

 private:
  /// One side, with the share of the sample rays that enter it.
  struct Child {
    const TriangleRange* triangles;
    double ratio;
  };

  bool IsDirect(const TriangleRange& triangles, const RayBlock& rays) const {
    return triangles.count() <= task_.settings.leaf_triangles ||
           rays.count <= task_.settings.leaf_rays;
  }

  bool SampleActiveRays(const RayBlock& rays) const {
    const bool sampled = rays.count > task_.settings.sample_threshold;
    TakeSampleRays(task_.batch, rays, sampled ? task_.settings.sample_rays : kFewSampleRays,
                   task_.scratch.samples);
    return sampled;
  }

  Children Partition(const TriangleRange& triangles, bool sampled, size_t depth) const {
    std::optional<Split> split;
    if (depth <= kMaxBinnedDepth) {
      split = ChooseSplit(task_.refs, triangles, task_.settings.bins, sampled, task_.scratch);
    }
    CountSplit(split.has_value(), sampled);
    return split ? PartitionTriangles(task_.refs, triangles, *split)
                 : HalveTriangles(task_.refs, triangles);
  }

  /// First the side that more sample rays enter first.
  std::array<Child, 2> OrderChildren(const Children& children) const {
    const SampleRays& samples = task_.scratch.samples;
    const SampleCounts counts =
        CountSamples(samples, children.left.bounds, children.right.bounds);
    const double share = 1.0 / static_cast<double>(samples.count);
    const Child left{&children.left, static_cast<double>(counts.left_hits) * share};
    const Child right{&children.right, static_cast<double>(counts.right_hits) * share};
    if (counts.right_closer > counts.left_closer) return {right, left};
    return {left, right};
  }

  bool SkipsFiltering(const Child& child) const {
    const size_t count = child.triangles->count();
    const bool skips = child.ratio > SkipRatio(count <= task_.settings.leaf_triangles, count);
    task_.statistics.filters_skipped += skips;
    return skips;
  }

  void SolveFiltered(const TriangleRange& triangles, const RayBlock& rays, size_t depth) const {
    task_.statistics.box_tests += rays.count;
    const auto filtered = FilterRays(task_.batch, rays, triangles.bounds);
    if (!filtered) {
      ++task_.statistics.filters_skipped;
      return Solve(triangles, rays, depth);
    }
    ++task_.statistics.filters;
    task_.statistics.rays_filtered += rays.count - filtered->block.count;
    if (filtered->block.count > 0) Solve(triangles, filtered->block, depth);
    ReturnDistances(task_.batch, rays, *filtered);
  }

  void CountSubproblem(size_t depth) const {
    ++task_.statistics.subproblems;
    task_.statistics.max_depth = std::max<uint64_t>(task_.statistics.max_depth, depth);
  }

  void CountSplit(bool by_bins, bool sampled) const {
    task_.statistics.median_splits += !by_bins;
    task_.statistics.sampled_splits += by_bins && sampled;
    task_.statistics.sah_splits += by_bins && !sampled;
  }

  const SolveTask& task_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_SOLVE_SOLVE_INL_H_
