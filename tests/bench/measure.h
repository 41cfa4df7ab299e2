// Timing, so that methods can be compared: in turn, the same rays, the same memory, and the same
// hits or none.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "frame.h"

namespace dacrt::bench {

/// What is compared: settings under a name.
struct Method {
  std::string name;
  Settings settings;
};

/// One timed Trace.
struct Run {
  double seconds;
  Statistics statistics;
};

/// All runs of one method over one pass.
struct Runs {
  std::vector<Run> runs;

  /// The run with the median time; of an even number, the faster of the two in the middle.
  const Run& Median() const;
  double LeastSeconds() const;
};

struct PassResult {
  Pass pass;
  std::size_t rays;
  std::vector<Runs> by_method;
};

struct FrameResult {
  std::string scene;
  std::size_t triangles;
  const FrameKind* kind;  ///< of FrameKinds()
  Raster raster;
  std::vector<Method> methods;
  std::vector<PassResult> passes;
  std::vector<std::size_t> workspace_bytes;  ///< held by the device of each method

  std::size_t Rays() const;                       ///< of all passes
  double Seconds(std::size_t method) const;       ///< sum of the passes' medians
  double LeastSeconds(std::size_t method) const;  ///< sum of the passes' least
  Statistics Total(std::size_t method) const;     ///< sum of the passes' median runs
  double Ratio(std::size_t method, std::size_t reference) const {
    return Seconds(method) / Seconds(reference);
  }
};

/// Methods ready to trace one scene, each with a device, and so a workspace, of its own.
class Contest {
 public:
  /// `scene` must outlive this.
  Contest(const BenchScene& scene, std::vector<Method> methods);

  const BenchScene& scene() const { return scene_; }

  /// Told what is about to be timed.
  using OnPass = std::function<void(const Pass& pass, std::size_t rays)>;

  /// Traces each pass of a frame `repeat` times with every method: one round of all methods after
  /// the other. A round before the first, which is not timed, brings the workspaces to their size
  /// and into memory; no later pass has more rays than the first.
  /// Throws Disagreement (errors.h).
  FrameResult Measure(const FrameKind& kind, const Raster& raster, int repeat,
                      const OnPass& on_pass) const;

 private:
  struct Entrant {
    Method method;
    std::shared_ptr<Device> device;
    std::unique_ptr<Scene> scene;
  };

  PassResult MeasurePass(const Pass& pass, int warm_ups, int repeat, RayBuffer& rays) const;

  const BenchScene& scene_;
  std::vector<Entrant> entrants_;
};

}  // namespace dacrt::bench
