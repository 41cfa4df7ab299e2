#include "ray_generation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "errors.h"
#include "random.h"

namespace dacrt::bench {
namespace {

using Imath::V3f;
using tests::Random;

// Shares of the diagonal of the scene. The offset is some eighty steps of single precision at the
// far end of the bounds: enough that a ray does not meet the surface that it starts on.
constexpr float kOffset = 1e-5f;
constexpr float kAmbientRadius = 0.1f;

// Share of the distance in focus: strong enough for the blur to cover many pixels.
constexpr float kLensRadius = 0.02f;

// What random numbers are for: each use has numbers of its own.
enum Purpose : uint64_t { kCamera, kOcclusion, kScatter };

Random RandomFor(uint32_t id, int bounce, Purpose purpose) {
  const uint64_t stream = static_cast<uint64_t>(bounce) * 4 + purpose;
  return Random(stream << 32 | id);
}

V3f Vector(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

void Append(RayBuffer& rays, const V3f& org, const V3f& dir, uint32_t id) {
  rays.Append({org.x, org.y, org.z}, {dir.x, dir.y, dir.z}, id);
}

// What a hit says of the surface.
struct SurfacePoint {
  V3f position;  // off the surface, on the side that the ray came from
  V3f normal;    // to the same side
};

SurfacePoint PointOf(const RayRecord& hit, float offset) {
  const V3f dir = Vector(hit.dir);
  V3f normal = Vector(hit.ng).normalized();
  if (normal.dot(dir) > 0) normal = -normal;
  return {Vector(hit.org) + dir * hit.tfar + normal * offset, normal};
}

// Calls `make` with every ray that hit something, and with its point.
template <class Make>
void ForEachHit(const RayBuffer& hits, float offset, const Make& make) {
  for (const RayRecord& hit : hits.rays()) {
    if (hit.geometry_id != kNoGeometry) make(hit, PointOf(hit, offset));
  }
}

// Two unit vectors at right angles to the unit normal and to each other; Duff et al., "Building an
// Orthonormal Basis, Revisited", 2017.
struct Tangents {
  explicit Tangents(const V3f& normal) {
    const float sign = std::copysign(1.0f, normal.z);
    const float a = -1 / (sign + normal.z);
    const float b = normal.x * normal.y * a;
    x = V3f(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x);
    y = V3f(b, sign + normal.y * normal.y * a, -normal.y);
  }
  V3f x, y;
};

// A point of the disc at right angles to the normal, as likely as the area.
V3f PointOfDisc(const Tangents& tangents, float squared_radius, Random& random) {
  const float angle = 2 * std::numbers::pi_v<float> * random.Uniform();
  const float radius = std::sqrt(squared_radius);
  return tangents.x * (radius * std::cos(angle)) + tangents.y * (radius * std::sin(angle));
}

// As likely as the cosine of the angle to the normal (Malley's method: up from the disc).
V3f CosineDirection(const V3f& normal, Random& random) {
  const float squared_radius = random.Uniform();
  return PointOfDisc(Tangents(normal), squared_radius, random) +
         normal * std::sqrt(1 - squared_radius);
}

V3f PointOfPanel(const Lamp& lamp, Random& random) {
  const float x = random.Uniform(-lamp.half_size, lamp.half_size);
  const float z = random.Uniform(-lamp.half_size, lamp.half_size);
  return lamp.centre + V3f(x, 0, z);
}

}  // namespace

Raster::Raster(uint32_t rays_a_side)
    : pixels_(std::clamp(rays_a_side, 1u, kMostPixelsASide)), samples_(rays_a_side / pixels_) {
  if (samples_ == 0 || pixels_ * samples_ != rays_a_side || rays_a_side > kMostRaysASide) {
    throw UsageError(std::to_string(rays_a_side) + " rays a side are neither from 1 to " +
                     std::to_string(kMostPixelsASide) + " nor a multiple of that up to " +
                     std::to_string(kMostRaysASide));
  }
}

RayGeneration::RayGeneration(const BenchScene& scene) : scene_(scene) {
  const float diagonal = Bounds(scene.mesh).size().length();
  offset_ = kOffset * diagonal;
  ambient_radius_ = kAmbientRadius * diagonal;
}

void RayGeneration::MakeCameraRays(const Raster& raster, bool thin_lens, RayBuffer& rays) const {
  const BenchView& view = scene_.view;
  const V3f forward = (view.look_at - view.eye).normalized();
  const V3f right = forward.cross(V3f(0, 1, 0)).normalized();
  const V3f down = forward.cross(right);
  const float focus = (view.look_at - view.eye).length();
  const float half = std::tan(view.vertical_fov * std::numbers::pi_v<float> / 360);
  const Tangents lens(forward);

  rays.Begin(kInfinity);
  const uint32_t side = raster.rays_a_side();
  const uint32_t samples = raster.samples_a_side();
  uint32_t id = 0;
  for (uint32_t pixel_y = 0; pixel_y < side; pixel_y += samples) {
    for (uint32_t pixel_x = 0; pixel_x < side; pixel_x += samples) {
      for (uint32_t y = pixel_y; y < pixel_y + samples; ++y) {
        for (uint32_t x = pixel_x; x < pixel_x + samples; ++x) {
          Random random = RandomFor(id, 0, kCamera);
          const float across = (2 * (x + random.Uniform()) / side - 1) * half;
          const float along = (2 * (y + random.Uniform()) / side - 1) * half;
          const V3f dir = (forward + right * across + down * along).normalized();
          if (thin_lens) {
            const float radius = kLensRadius * focus;
            const float squared_radius = radius * radius * random.Uniform();
            const V3f on_lens = PointOfDisc(lens, squared_radius, random);
            const V3f in_focus = dir * (focus / dir.dot(forward));
            Append(rays, view.eye + on_lens, (in_focus - on_lens).normalized(), id);
          } else {
            Append(rays, view.eye, dir, id);
          }
          ++id;
        }
      }
    }
  }
}

void RayGeneration::MakeOcclusionRays(Occlusion occlusion, int bounce, const RayBuffer& hits,
                                      RayBuffer& rays) const {
  const Lamp& lamp = scene_.lamp;
  // A ray to or from a light is as long as its direction.
  rays.Begin(occlusion == Occlusion::kAmbient ? ambient_radius_ : 1.0f);
  ForEachHit(hits, offset_, [&](const RayRecord& hit, const SurfacePoint& point) {
    Random random = RandomFor(hit.id, bounce, kOcclusion);
    switch (occlusion) {
      case Occlusion::kPointLight: {
        const V3f from_light = point.position - lamp.centre;
        if (from_light.dot(point.normal) < 0) Append(rays, lamp.centre, from_light, hit.id);
        break;
      }
      case Occlusion::kPanelLight: {
        const V3f to_light = PointOfPanel(lamp, random) - point.position;
        if (to_light.dot(point.normal) > 0) Append(rays, point.position, to_light, hit.id);
        break;
      }
      case Occlusion::kAmbient:
        Append(rays, point.position, CosineDirection(point.normal, random), hit.id);
        break;
    }
  });
}

void RayGeneration::Continue(Scatter scatter, int bounce, const RayBuffer& hits,
                             RayBuffer& rays) const {
  rays.Begin(kInfinity);
  ForEachHit(hits, offset_, [&](const RayRecord& hit, const SurfacePoint& point) {
    if (scatter == Scatter::kMirror) {
      const V3f dir = Vector(hit.dir);
      const V3f mirrored = dir - point.normal * (2 * dir.dot(point.normal));
      Append(rays, point.position, mirrored, hit.id);
    } else {
      Random random = RandomFor(hit.id, bounce, kScatter);
      Append(rays, point.position, CosineDirection(point.normal, random), hit.id);
    }
  });
}

}  // namespace dacrt::bench
