// Divide-and-conquer ray tracing by object partition: nabata2013 and afra2012.
//
// Nabata, Iwasaki, Dobashi, Nishita, "Efficient Divide-And-Conquer Ray Tracing using Ray Sampling",
// HPG 2013. Afra, "Incoherent ray tracing without acceleration structures", EG 2012 short papers:
// the same recursion where the partition follows the surface area heuristic, the order the rays'
// directions, and no filtering is skipped.

#if defined(DACRT_PAPER_SOLVE_OBJECTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_SOLVE_OBJECTS_INL_H_
#undef DACRT_PAPER_SOLVE_OBJECTS_INL_H_
#else
#define DACRT_PAPER_SOLVE_OBJECTS_INL_H_
#endif

#include <array>
#include <cmath>

#include "paper/split_cost.h"
#include "paper/solver-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The parts of the method that are in use.
struct SampledParts {
  bool cost;
  bool order;
  bool skip;

  explicit SampledParts(const Settings& settings) {
    const bool sampled = settings.algorithm == Algorithm::kNabata2013;
    cost = sampled && settings.sampled_cost;
    order = sampled && settings.sampled_order;
    skip = sampled && settings.skip_filtering;
  }
};

template <Query kQuery>
class ObjectSolver : Solver<kQuery> {
 public:
  explicit ObjectSolver(const PaperTask& task) : Base(task), parts_(task.settings) {}

  void Solve(const TriangleRange& triangles, const RayBlock& rays, size_t depth) const {
    if (Base::IsDirect(triangles, rays, depth)) return Base::SolveDirectly(triangles, rays);
    const bool sampled = SampleActiveRays(rays);
    const Children children = Base::PartitionObjects(triangles, sampled, depth);
    for (const Child& child : OrderChildren(children)) {
      if (SkipsFiltering(child) || !SolveFiltered(*child.triangles, rays, depth + 1)) {
        Solve(*child.triangles, rays, depth + 1);
      }
    }
  }

 private:
  using Base = Solver<kQuery>;
  using Base::task_;

  /// One side, with the share of the sample rays that enter it.
  struct Child {
    const TriangleRange* triangles;
    double ratio;
  };

  /// Returns whether there are rays enough for the sample to choose the partition.
  bool SampleActiveRays(const RayBlock& rays) const {
    const bool sampled = parts_.cost && rays.count > task_.settings.sample_threshold;
    Base::TakeSamples(
        rays, sampled ? SampleCount(rays.count, task_.settings.sample_rays) : kFewSampleRays);
    return sampled;
  }

  /// First the side that more sample rays enter first, or that lies first in their directions.
  std::array<Child, 2> OrderChildren(const Children& children) const {
    const StepClock::Charge charge(task_.clock, Step::kSampling);
    const SampleRays& samples = task_.scratch.samples;
    Child left{&children.left, 1.0}, right{&children.right, 1.0};
    bool right_first = false;
    if (parts_.order || parts_.skip) {
      const SampleCounts counts =
          CountSamples(samples, children.left.bounds, children.right.bounds);
      const double share = 1.0 / static_cast<double>(samples.count);
      left.ratio = static_cast<double>(counts.left_hits) * share;
      right.ratio = static_cast<double>(counts.right_hits) * share;
      right_first = counts.right_closer > counts.left_closer;
    }
    if (!parts_.order) right_first = LiesFirst(children.right.bounds, children.left.bounds);
    if (right_first) return {right, left};
    return {left, right};
  }

  /// Whether most sample rays run from `box` towards `other`, on the axis on which they lie apart.
  bool LiesFirst(const Box& box, const Box& other) const {
    int axis = 0;
    float apart[3];
    for (int i = 0; i < 3; ++i) {
      apart[i] = (other.lower[i] + other.upper[i]) - (box.lower[i] + box.upper[i]);
      if (std::abs(apart[i]) > std::abs(apart[axis])) axis = i;
    }
    const SampleRays& samples = task_.scratch.samples;
    size_t along = 0;
    for (size_t i = 0; i < samples.count; ++i) along += samples.reciprocal[axis][i] > 0;
    return apart[axis] > 0 ? 2 * along > samples.count : 2 * along < samples.count;
  }

  bool SkipsFiltering(const Child& child) const {
    const TriangleRange& triangles = *child.triangles;
    const bool skips =
        parts_.skip && child.ratio > SkipRatio(Base::IsLeaf(triangles), triangles.count());
    task_.statistics.filters_skipped += skips;
    return skips;
  }

  bool SolveFiltered(const TriangleRange& triangles, const RayBlock& rays, size_t depth) const {
    return Base::WithFilteredRays({&rays, 1}, triangles.bounds, [&](const RayBlock& active_rays) {
      Solve(triangles, active_rays, depth);
    });
  }

  SampledParts parts_;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_SOLVE_OBJECTS_INL_H_
