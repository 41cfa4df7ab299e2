#include "lidar/cloud_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lidar/street.h"

namespace lidar {
namespace {

using Imath::V3f;

const V3f kEye(-14, 16, -6), kLookAt(26, 2, 1);
constexpr float kTangentOfHalfView = 0.5f;  // upwards and downwards
constexpr float kHighest = 16;              // metres, of the scale of colours
constexpr float kBackground = 0.012f;

V3f ColourOf(const Point& point) {
  const float light = 0.15f + 0.85f * float(point.intensity) / 255;
  if (point.geometry == kVan) return V3f(light);
  const float height = std::clamp(point.position.y / kHighest, 0.0f, 1.0f);
  const auto hump = [&](float middle) {
    return std::clamp(1.5f - 3.2f * std::abs(height - middle), 0.05f, 1.0f);
  };
  return V3f(hump(0.95f), hump(0.5f), hump(0)) * light;
}

}  // namespace

ao::Image DrawCloud(std::span<const Point> points, uint32_t width, uint32_t height) {
  ao::Image image{width, height, std::vector<float>(size_t(width) * height * 3, kBackground)};
  std::vector<float> depth(size_t(width) * height, std::numeric_limits<float>::infinity());
  const V3f forward = (kLookAt - kEye).normalized();
  const V3f right = forward.cross(V3f(0, 1, 0)).normalized();
  const V3f up = right.cross(forward);
  const float scale = float(height) / 2 / kTangentOfHalfView;
  for (const Point& point : points) {
    const V3f to = point.position - kEye;
    const float distance = to.dot(forward);
    if (distance <= 0.1f) continue;
    const float x = float(width) / 2 + scale * to.dot(right) / distance;
    const float y = float(height) / 2 - scale * to.dot(up) / distance;
    if (!(x >= 0 && x < float(width) && y >= 0 && y < float(height))) continue;
    const size_t pixel = size_t(y) * width + size_t(x);
    if (distance >= depth[pixel]) continue;
    depth[pixel] = distance;
    const V3f colour = ColourOf(point);
    for (int channel = 0; channel < 3; ++channel)
      image.pixels[3 * pixel + channel] = colour[channel];
  }
  return image;
}

}  // namespace lidar
