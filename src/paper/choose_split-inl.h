// The choice among the candidate partitions.
// Nabata et al. 2013, "Partitioning using Cost Function".

#if defined(DACRT_PAPER_CHOOSE_SPLIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_CHOOSE_SPLIT_INL_H_
#undef DACRT_PAPER_CHOOSE_SPLIT_INL_H_
#else
#define DACRT_PAPER_CHOOSE_SPLIT_INL_H_
#endif

#include <optional>

#include "paper/binning-inl.h"
#include "paper/split_cost.h"
#include "paper/sample_rays-inl.h"
#include "partition/partition_triangles-inl.h"
#include "runtime/step_clock.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Cost of a candidate by how many of the sample rays enter its sides.
inline double SampledCost(const SplitCandidate& candidate, const SampleRays& samples) {
  const SampleCounts counts = CountSamples(samples, candidate.left_box, candidate.right_box);
  const double share = 1.0 / static_cast<double>(samples.count);
  return SplitCost(static_cast<double>(counts.left_hits) * share, candidate.left_count,
                   static_cast<double>(counts.right_hits) * share, candidate.right_count);
}

/// Cost of a candidate by the surfaces of its sides.
inline double SurfaceCost(const SplitCandidate& candidate, const Box& parent) {
  const double area = parent.HalfArea();
  if (!(area > 0)) return static_cast<double>(candidate.left_count + candidate.right_count);
  return SplitCost(candidate.left_box.HalfArea() / area, candidate.left_count,
                   candidate.right_box.HalfArea() / area, candidate.right_count);
}

/// The candidate of least cost, by the sample rays if `sampled`; nothing if the centres coincide,
/// so that no candidate has triangles on both sides.
inline std::optional<Split> ChooseSplit(const TriangleRef* refs, const TriangleRange& triangles,
                                        uint32_t bins, bool sampled, Scratch& scratch,
                                        StepClock& clock) {
  const BinMap map(triangles.centers, bins);
  {
    const StepClock::Charge charge(clock, Step::kBinning);
    BinTriangles(refs, triangles, map, bins, scratch);
    MakeCandidates(bins, scratch);
  }
  const StepClock::Charge charge(clock, sampled ? Step::kSampling : Step::kBinning);
  std::optional<Split> best;
  double best_cost = 0, best_surface_cost = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!map.IsUseful(axis)) continue;
    for (uint32_t k = 0; k + 1 < bins; ++k) {
      const SplitCandidate& candidate = scratch.candidates[axis][k];
      if (candidate.left_count == 0 || candidate.right_count == 0) continue;
      const double surface_cost = SurfaceCost(candidate, triangles.bounds);
      const double cost = sampled ? SampledCost(candidate, scratch.samples) : surface_cost;
      // A hundred samples tell few costs apart; the surfaces decide among equals.
      const bool better =
          cost < best_cost || (cost == best_cost && surface_cost < best_surface_cost);
      if (best && !better) continue;
      best_cost = cost;
      best_surface_cost = surface_cost;
      best = Split{map, axis, k, candidate.left_count, candidate.left_box, candidate.right_box};
    }
  }
  return best;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_CHOOSE_SPLIT_INL_H_
