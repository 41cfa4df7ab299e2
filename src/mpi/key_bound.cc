#include "key_bound.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace dacrt::mpi {
namespace {

/// By how much the engine's distance to a box may differ from the true one, in parts of it and of
/// what it is computed from: a few roundings to single precision, generously.
constexpr double kEntrySlack = 0x1p-19;

}  // namespace

KeyBounds::KeyBounds(std::span<const Geometry> geometries) {
  for (const Geometry& geometry : geometries) {
    const bool is_mesh = geometry.shape == Shape::kTriangles && geometry.vertices.size() == 1;
    const auto [place, is_new] = by_id_.try_emplace(geometry.geometry_id);
    if (is_mesh && is_new) {
      place->second = {geometry.vertices[0], geometry.primitives, true};
    } else {
      place->second.is_known = false;
    }
  }
}

float KeyBounds::MostOf(const TravellingRay& ray, const HitRecord& hit) const {
  if (hit.instance_id != UINT32_MAX) return kInfinity;
  const auto place = by_id_.find(hit.geometry_id);
  if (place == by_id_.end() || !place->second.is_known) return kInfinity;
  const auto read = [](const Array& array, std::size_t i, auto& values) {
    std::memcpy(&values, static_cast<const std::byte*>(array.data) + i * array.stride,
                sizeof(values));
  };
  uint32_t corners[3];
  read(place->second.primitives, hit.primitive_id, corners);
  float vertices[3][3];
  for (int corner = 0; corner < 3; ++corner) {
    read(place->second.vertices, corners[corner], vertices[corner]);
  }
  double most = hit.t;
  for (int axis = 0; axis < 3; ++axis) {
    const double dir = ray.dir[axis], org = ray.org[axis];
    if (dir == 0) continue;
    const auto [low, high] = std::minmax({vertices[0][axis], vertices[1][axis], vertices[2][axis]});
    const double entry = ((dir > 0 ? low : high) - org) / dir;
    const double size = std::max(
        {std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high)), std::abs(org)});
    most = std::max(most, entry + kEntrySlack * (std::abs(entry) + size / std::abs(dir)));
  }
  return std::nextafter(static_cast<float>(most), kInfinity);
}

}  // namespace dacrt::mpi
