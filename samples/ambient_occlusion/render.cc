#include "ambient_occlusion/render.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "ambient_occlusion/progress.h"
#include "ambient_occlusion/sampling.h"
#include "ambient_occlusion/stopwatch.h"

namespace ao {
namespace {

using Imath::V3f;

constexpr V3f kStone(0.94f, 0.91f, 0.87f);  // where nothing occludes
constexpr float kContrast = 1.6f;           // exponent
constexpr V3f kSky(0.62f, 0.74f, 0.88f);    // where there is nothing

constexpr size_t kOcclusionRaysPerCall = size_t(1) << 21;

// Pixels tile by tile, so that rays which follow one another in the stream stay close.
std::vector<uint32_t> PixelsInTiles(uint32_t width, uint32_t height) {
  constexpr uint32_t kTile = 8;
  std::vector<uint32_t> pixels;
  pixels.reserve(size_t(width) * height);
  for (uint32_t top = 0; top < height; top += kTile) {
    for (uint32_t left = 0; left < width; left += kTile) {
      for (uint32_t y = top; y < std::min(top + kTile, height); ++y) {
        for (uint32_t x = left; x < std::min(left + kTile, width); ++x) {
          pixels.push_back(y * width + x);
        }
      }
    }
  }
  return pixels;
}

class Renderer {
 public:
  Renderer(const Options& options, const Scene& scene, const Camera& camera)
      : options_(options),
        scene_(scene),
        camera_(camera),
        pixels_(PixelsInTiles(options.width, options.height)),
        rays_(pixels_.size() * options.samples_per_pixel) {
    const Imath::Box3f bounds = scene.Bounds();
    constexpr float kRadius = 0.15f;  // of the diagonal
    radius_ = options.ao_radius.value_or(kRadius * bounds.size().length());
    // A hit is exact to a few units in the last place of its coordinates, of 2^-24 each; this is
    // some hundred of them.
    const V3f far(std::max(-bounds.min.x, bounds.max.x), std::max(-bounds.min.y, bounds.max.y),
                  std::max(-bounds.min.z, bounds.max.z));
    offset_ = 0x1p-17f * std::max({far.x, far.y, far.z});
  }

  Rendering Render() {
    Rendering rendering;
    rendering.closest_hit = TraceCameraRays();
    rendering.occlusion = TraceOcclusionRays();
    rendering.image = MakeImage();
    return rendering;
  }

 private:
  uint32_t PixelOf(size_t ray) const { return pixels_[ray / options_.samples_per_pixel]; }
  bool IsHit(size_t ray) const { return rays_[ray].hit.geomID != RTC_INVALID_GEOMETRY_ID; }

  Traced TraceCameraRays() {
    const Progress progress("camera rays");
    const uint32_t samples = options_.samples_per_pixel;
    tbb::parallel_for(size_t(0), pixels_.size(), [&](size_t i) {
      const PixelSamples jitter(pixels_[i], options_.seed, samples);
      const float x = float(pixels_[i] % options_.width);
      const float y = float(pixels_[i] / options_.width);
      for (uint32_t sample = 0; sample < samples; ++sample) {
        const Imath::V2f within = jitter(sample);
        rays_[i * samples + sample] =
            MakeRayHit(camera_.eye(), camera_.DirectionThrough(x + within.x, y + within.y));
      }
    });
    const Stopwatch stopwatch;
    scene_.Intersect(rays_.data(), unsigned(rays_.size()), RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
    return {rays_.size(), stopwatch.Seconds()};
  }

  Traced TraceOcclusionRays() {
    std::vector<uint32_t> hits;
    for (size_t ray = 0; ray < rays_.size(); ++ray) {
      if (IsHit(ray)) hits.push_back(uint32_t(ray));
    }
    open_.assign(rays_.size(), 0);

    const size_t samples = options_.ao_samples;
    const size_t hits_per_call = std::max<size_t>(1, kOcclusionRaysPerCall / samples);
    std::vector<RTCRay> rays(std::min(hits_per_call, hits.size()) * samples);
    Traced traced;
    Progress progress("occlusion rays");
    for (size_t first = 0; first < hits.size(); first += hits_per_call) {
      const size_t count = std::min(hits_per_call, hits.size() - first);
      tbb::parallel_for(size_t(0), count,
                        [&](size_t i) { MakeOcclusionRays(hits[first + i], &rays[i * samples]); });
      const Stopwatch stopwatch;
      scene_.Occlude(rays.data(), unsigned(count * samples));
      traced.seconds += stopwatch.Seconds();
      traced.rays += count * samples;
      tbb::parallel_for(size_t(0), count, [&](size_t i) {
        open_[hits[first + i]] =
            uint32_t(std::count_if(&rays[i * samples], &rays[i * samples] + samples,
                                   [](const RTCRay& ray) { return ray.tfar >= 0; }));
      });
      progress.Update(double(first + count) / double(hits.size()));
    }
    return traced;
  }

  void MakeOcclusionRays(size_t hit, RTCRay* rays) const {
    const RTCRay& ray = rays_[hit].ray;
    const V3f direction(ray.dir_x, ray.dir_y, ray.dir_z);
    V3f normal(rays_[hit].hit.Ng_x, rays_[hit].hit.Ng_y, rays_[hit].hit.Ng_z);
    normal.normalize();
    if (normal.dot(direction) > 0) normal = -normal;
    const V3f origin =
        V3f(ray.org_x, ray.org_y, ray.org_z) + direction * ray.tfar + normal * offset_;

    // One sequence for the whole pixel, of which every camera ray takes its part.
    const uint32_t part = uint32_t(hit % options_.samples_per_pixel);
    const PixelSamples sequence(PixelOf(hit), Hash(options_.seed) + 1,
                                options_.samples_per_pixel * options_.ao_samples);
    for (uint32_t i = 0; i < options_.ao_samples; ++i) {
      const Imath::V2f sample = sequence(i * options_.samples_per_pixel + part);
      rays[i] = MakeRay(origin, CosineDirection(normal, sample), radius_);
    }
  }

  Image MakeImage() const {
    Image image{options_.width, options_.height, std::vector<float>(3 * pixels_.size())};
    const uint32_t samples = options_.samples_per_pixel;
    tbb::parallel_for(size_t(0), pixels_.size(), [&](size_t i) {
      V3f sum(0);
      for (size_t ray = i * samples; ray < (i + 1) * samples; ++ray) {
        sum += IsHit(ray) ? kStone * std::pow(float(open_[ray]) / options_.ao_samples, kContrast)
                          : kSky;
      }
      const V3f color = sum / samples;
      std::copy(&color.x, &color.x + 3, &image.pixels[3 * size_t(pixels_[i])]);
    });
    return image;
  }

  const Options& options_;
  const Scene& scene_;
  const Camera& camera_;
  float radius_;
  float offset_;  // of occlusion rays from the surface
  std::vector<uint32_t> pixels_;
  std::vector<RTCRayHit> rays_;  // of the camera: all of the first pixel, then of the next
  std::vector<uint32_t> open_;   // for each of them, the occlusion rays that met nothing
};

}  // namespace

Rendering Render(const Options& options, const Scene& scene, const Camera& camera) {
  return Renderer(options, scene, camera).Render();
}

}  // namespace ao
