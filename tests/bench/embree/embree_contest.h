// The drop-in against Embree on one scene.
#pragma once

#include <functional>
#include <string>

#include "embree_at_best.h"
#include "embree_results.h"
#include "ray_kind.h"

namespace dacrt::bench {

/// Both libraries on one scene, on a number of threads. Contests for different numbers must not be
/// there at the same time: see EmbreeLibrary.
///
/// Embree traces on the threads that call it. The drop-in is called from one, with the whole batch:
/// its device has threads of its own.
class EmbreeContest {
 public:
  /// `scene` must outlive this.
  EmbreeContest(const BenchScene& scene, int threads);

  /// The rays of a picture that a cell is measured with.
  RayBuffer MakeRays(const Cell& cell);

  using OnStep = std::function<void(const std::string& step)>;

  /// Measures Embree's best in turn with the drop-in, on the same rays in the same memory, of which
  /// there must be one. Where the batches are slices of the picture, keeps the rays of those that
  /// it has measured. Throws Disagreement (errors.h) if the numbers of hits are apart by more than
  /// a ten-thousandth.
  CellResult Measure(const Cell& cell, int repeat, const OnStep& on_step, RayBuffer& rays) const;

  /// What both libraries take for a call with all the rays, which are for closest hits.
  MemoryResult MeasureMemory(const Cell& cell, RayBuffer& rays) const;

 private:
  const BenchScene& scene_;
  const std::string config_;  ///< of each library's device
  EmbreeAtBest embree_;
  EmbreeLibrary drop_in_;
  RaySource rays_;
};

}  // namespace dacrt::bench
