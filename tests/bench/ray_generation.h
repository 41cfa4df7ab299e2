// The renderer behind the frames: rays made from a camera and from hits, nothing shaded.
//
// Deterministic: a ray's random numbers follow from the camera ray it descends from, the bounce and
// what they are for, so every method gets the same rays whatever was measured before.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bench_scene.h"
#include "ray_buffer.h"

namespace dacrt::bench {

/// What is asked of every hit, as an any-hit query.
enum class Occlusion {
  kPointLight,  ///< from the lamp's centre to the hit: rays from one point, as Mora traces them
  kPanelLight,  ///< from the hit to a random point of the lamp's panel
  kAmbient,     ///< a random direction of the hemisphere, for a limited distance
};

/// Where a path goes on from a hit.
enum class Scatter {
  kMirror,   ///< reflected, by every surface
  kDiffuse,  ///< a random direction, by the cosine of its angle to the normal
};

/// How many camera rays there are: pixels in rows, and samples one after the other in each pixel.
class Raster {
 public:
  static constexpr uint32_t kMostPixelsASide = 512;
  static constexpr uint32_t kMostRaysASide = 8192;

  /// For `rays_a_side` x `rays_a_side` rays. As in the paper, a picture has at most 512 x 512
  /// pixels, and more rays are more samples a pixel: at most kMostPixelsASide, or a multiple of it
  /// up to kMostRaysASide. Throws UsageError (errors.h) otherwise.
  explicit Raster(uint32_t rays_a_side);

  /// The same number of rays, of which each pixel has `samples_a_side` squared, however many pixels
  /// those are. They must divide the rays.
  static Raster OfSamples(uint32_t rays_a_side, uint32_t samples_a_side) {
    return Raster(rays_a_side / samples_a_side, samples_a_side);
  }

  bool operator==(const Raster&) const = default;

  uint32_t rays_a_side() const { return pixels_ * samples_; }
  uint32_t pixels_a_side() const { return pixels_; }
  uint32_t samples_a_side() const { return samples_; }
  std::size_t RayCount() const { return std::size_t{rays_a_side()} * rays_a_side(); }

 private:
  Raster(uint32_t pixels, uint32_t samples) : pixels_(pixels), samples_(samples) {}

  uint32_t pixels_;   ///< along one side
  uint32_t samples_;  ///< along one side of a pixel
};

class RayGeneration {
 public:
  /// `scene` must outlive this.
  explicit RayGeneration(const BenchScene& scene);

  void MakeCameraRays(const Raster& raster, bool thin_lens, RayBuffer& rays) const;

  void MakeOcclusionRays(Occlusion occlusion, int bounce, const RayBuffer& hits,
                         RayBuffer& rays) const;

  void Continue(Scatter scatter, int bounce, const RayBuffer& hits, RayBuffer& rays) const;

 private:
  const BenchScene& scene_;
  float offset_;          ///< of a ray's end from the surface it lies on
  float ambient_radius_;  ///< how far ambient occlusion looks
};

}  // namespace dacrt::bench
