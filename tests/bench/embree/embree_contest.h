// The drop-in against Embree on one scene.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "embree_at_best.h"
#include "embree_results.h"
#include "ray_kind.h"

namespace dacrt::bench {

/// How long a cell is measured.
struct Effort {
  int repeat = 3;  ///< rounds, of which the median counts; more while they are short
  double rounds_seconds = 0.5;
  double warm_seconds = 1;          ///< of calls to a still scene before those that are measured
  double slices_seconds = 0.25;     ///< of slices, as many as the drop-in takes so long for
  std::uint32_t sliced_side = 512;  ///< of the picture that is sliced
};

/// What both libraries are limited to, and what they are measured for.
struct ContestSetup {
  std::string isa;
  int threads = 1;
  bool anew = false;  ///< cells that have a one shot (cell_list.h) are measured with it
  std::string embree, drop_in;  ///< the libraries
};

/// Both libraries on one scene, with the same instruction set and number of threads. Contests for
/// different numbers must not be there at the same time: see EmbreeLibrary.
///
/// Embree traces streams on the threads that call it. The drop-in gets a batch that is one picture
/// in one call, from one thread: its device has threads of its own. Single rays, packets and streams
/// that are slices of a picture are sent from as many threads to both.
class EmbreeContest {
 public:
  /// `content` is made of `scene`; both must outlive this.
  EmbreeContest(const BenchScene& scene, const SceneContent& content, const ContestSetup& setup,
                const Effort& effort);

  /// The rays of a picture that a cell is measured with.
  RayBuffer MakeRays(const Cell& cell);

  using OnStep = std::function<void(const std::string& step)>;

  /// Measures Embree's best in turn with the drop-in, on the same rays in the same memory, of which
  /// there must be as many as a call takes. Where the batches are slices of the picture, keeps the
  /// rays of those that it has measured. Throws Disagreement (errors.h) if the hits are apart.
  CellResult Measure(const Cell& cell, const OnStep& on_step, RayBuffer& rays);

 private:
  const CommittedScene& StillDropIn();

  const BenchScene& scene_;
  const SceneContent& content_;
  const ContestSetup setup_;
  const Effort effort_;
  EmbreeAtBest embree_;
  EmbreeLibrary drop_in_;
  RaySource rays_;
  std::optional<CommittedScene> still_drop_in_;  ///< made when rays have been
};

}  // namespace dacrt::bench
