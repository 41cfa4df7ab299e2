// The kinds of rays that the libraries are compared on.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "ray_generation.h"
#include "scene_content.h"

namespace dacrt::bench {

struct RayKind {
  const char* name;
  Query query;
  /// Samples of a pixel along one of its sides: the rays of a pixel follow each other.
  std::uint32_t samples_a_side;
  /// Makes the rays from the hits of the primary rays; null where they are the primary rays.
  void (*make)(const RayGeneration& generation, const RayBuffer& primary_hits, RayBuffer& rays);
};

/// primary, shadow (any hit, from a point light), ambient (any hit), diffuse (closest hit), at one
/// ray a pixel; primary-4 and shadow-4, at four.
std::span<const RayKind> RayKinds();

/// Null if there is none of this name.
const RayKind* FindRayKind(const std::string& name);

/// Makes the rays of one scene, in the order of the picture.
class RaySource {
 public:
  /// Traces for closest hits.
  using Trace = std::function<void(RayBuffer& rays)>;

  /// `scene` must outlive this.
  explicit RaySource(const BenchScene& scene, const RayNeeds& needs = {})
      : generation_(scene), needs_(needs) {}

  /// Rays of a picture of `rays_a_side` x `rays_a_side` primary rays. `trace` finds the hits of
  /// these, unless the last call was about the same picture.
  RayBuffer Make(const RayKind& kind, std::uint32_t rays_a_side, const Trace& trace);

 private:
  RayBuffer MakePrimary(const Raster& picture) const;
  void GiveNeeds(RayBuffer& rays) const;

  RayGeneration generation_;
  RayNeeds needs_;
  std::optional<Raster> hits_picture_;
  std::optional<RayBuffer> primary_hits_;
};

}  // namespace dacrt::bench
