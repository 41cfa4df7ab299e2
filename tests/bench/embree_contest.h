// The drop-in against Embree on one scene.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "embree_library.h"
#include "ray_generation.h"

namespace dacrt::bench {

/// A way to use Embree.
struct EmbreeVariant {
  std::string isa;
  RTCBuildQuality quality;
  Call call;
};

std::string Name(const EmbreeVariant& variant);

/// Seconds, one value a round.
struct Times {
  std::vector<double> commit;  ///< of a scene not seen before
  std::vector<double> first;   ///< the first call on it
  std::vector<double> steady;  ///< a later call on a still scene

  double OneShot() const;  ///< median of commit and first call together
};

struct EmbreeResult {
  std::string scene;
  std::size_t triangles;
  std::string kind;
  std::size_t rays;
  EmbreeVariant best_one_shot, best_steady;
  Times embree, dacrt;

  double OneShotRatio() const;
  double SteadyRatio() const;
};

/// Rays of one call.
struct RayKind {
  const char* name;
  Query query;
  void (*make)(const RayGeneration& generation, const RayBuffer& primary_hits, RayBuffer& rays);
};

/// primary, shadow (any hit, from a point light), ambient (any hit), diffuse (closest hit).
std::vector<RayKind> RayKinds();

class EmbreeContest {
 public:
  EmbreeContest();

  using OnStep = std::function<void(const std::string& step)>;

  /// First tries every variant of Embree once, which also brings everything into memory; then
  /// measures its best two, for one shot and for steady use, in turn with the drop-in.
  /// Throws Disagreement if the numbers of hits are apart by more than a ten-thousandth.
  EmbreeResult Measure(const BenchScene& scene, const RayKind& kind, const Raster& raster,
                       int repeat, const OnStep& on_step) const;

 private:
  struct Embree {
    std::string isa;
    EmbreeLibrary library;
  };
  struct Best;

  const EmbreeLibrary& Library(const EmbreeVariant& variant) const;
  Best FindBest(const BenchScene& scene, Query query, RayBuffer& rays) const;

  std::vector<Embree> embrees_;  ///< one for each instruction set
  EmbreeLibrary drop_in_;
};

}  // namespace dacrt::bench
