// The kinds of rays that the libraries are compared on.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "ray_generation.h"

namespace dacrt::bench {

struct RayKind {
  const char* name;
  Query query;
  /// Makes the rays from the hits of the primary rays; null where they are the primary rays.
  void (*make)(const RayGeneration& generation, const RayBuffer& primary_hits, RayBuffer& rays);
};

/// primary, shadow (any hit, from a point light), ambient (any hit), diffuse (closest hit).
std::span<const RayKind> RayKinds();

/// Null if there is none of this name.
const RayKind* FindRayKind(const std::string& name);

/// Makes the rays of one scene, in the order of the picture.
class RaySource {
 public:
  /// Traces for closest hits.
  using Trace = std::function<void(RayBuffer& rays)>;

  /// `scene` must outlive this.
  explicit RaySource(const BenchScene& scene) : generation_(scene) {}

  /// Rays of a picture. `trace` finds the hits of its primary rays, unless the last call was about
  /// the same picture.
  RayBuffer Make(const RayKind& kind, const Raster& picture, const Trace& trace);

 private:
  RayGeneration generation_;
  std::optional<RayBuffer> primary_hits_;
};

}  // namespace dacrt::bench
