#include "lidar/scanner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lidar {
namespace {

using Imath::V3f;

constexpr float kHeight = 2.2f;                      // metres
constexpr float kLowest = -0.42f, kHighest = 0.35f;  // radians, of the beams
constexpr float kStart = 8, kLane = 1.8f;            // metres along and across the street
constexpr float kReachOfFullLight = 15;              // metres

}  // namespace

V3f ScannerAt(float seconds) { return {kStart + kSpeed * seconds, kHeight, kLane}; }

std::vector<dacrt::RayHit> MakeSweep(uint32_t sweep, uint32_t count) {
  const uint32_t turns = (count + kBeams - 1) / kBeams;
  std::vector<dacrt::RayHit> rays;
  rays.reserve(size_t(turns) * kBeams);
  for (uint32_t turn = 0; turn < turns; ++turn) {
    const float part = float(turn) / float(turns);
    const V3f from = ScannerAt((float(sweep) + part) * kSecondsASweep);
    const float azimuth = 2 * std::numbers::pi_v<float> * part;
    for (uint32_t beam = 0; beam < kBeams; ++beam) {
      const float elevation = kLowest + (kHighest - kLowest) * float(beam) / float(kBeams - 1);
      const float level = std::cos(elevation);
      dacrt::Ray ray;
      ray.org[0] = from.x, ray.org[1] = from.y, ray.org[2] = from.z;
      ray.dir[0] = level * std::cos(azimuth);
      ray.dir[1] = std::sin(elevation);
      ray.dir[2] = level * std::sin(azimuth);
      ray.tfar = kRange;
      rays.push_back({ray, {}});
    }
  }
  return rays;
}

void AddPoints(std::span<const dacrt::RayHit> rays, std::vector<Point>* points) {
  for (const dacrt::RayHit& ray : rays) {
    if (!ray.hit) continue;
    const auto [x, y, z] = ray.Position();
    const V3f normal(ray.hit.ng[0], ray.hit.ng[1], ray.hit.ng[2]);
    const V3f direction(ray.ray.dir[0], ray.ray.dir[1], ray.ray.dir[2]);
    const float facing = std::abs(normal.normalized().dot(direction));
    const float light = facing * std::min(1.0f, kReachOfFullLight / ray.ray.tfar);
    points->push_back({{x, y, z}, uint8_t(std::lround(255 * light)), uint8_t(ray.hit.geometry_id)});
  }
}

}  // namespace lidar
