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

/// Of a hit of this triangle.
float MostOf(const RayRecord& ray, const float (&vertices)[3][3]) {
  double most = ray.tfar;
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

const KeyBounds::Triangles* KeyBounds::TrianglesOf(const RayRecord& ray) const {
  if (ray.instance_id != UINT32_MAX) return nullptr;
  const auto place = by_id_.find(ray.geometry_id);
  return place != by_id_.end() && place->second.is_known ? &place->second : nullptr;
}

void KeyBounds::Find(std::span<Asked> hits) const {
  struct Looked {
    Asked* hit;
    const Triangles* triangles;
    const std::byte* primitive;
    const std::byte* vertices[3];
  };
  const auto item = [](const Array& array, std::size_t i) {
    return static_cast<const std::byte*>(array.data) + i * array.stride;
  };
  Looked looked[kMost];
  std::size_t count = 0;
  for (Asked& hit : hits) {
    const Triangles* const triangles = TrianglesOf(*hit.ray);
    if (!triangles) continue;
    const std::byte* const primitive = item(triangles->primitives, hit.ray->primitive_id);
    __builtin_prefetch(primitive);
    looked[count++] = {&hit, triangles, primitive, {}};
  }
  const std::span<Looked> known(looked, count);
  for (Looked& look : known) {
    uint32_t corners[3];
    std::memcpy(corners, look.primitive, sizeof(corners));
    for (int corner = 0; corner < 3; ++corner) {
      look.vertices[corner] = item(look.triangles->vertices, corners[corner]);
      __builtin_prefetch(look.vertices[corner]);
    }
  }
  for (Looked& look : known) {
    float vertices[3][3];
    for (int corner = 0; corner < 3; ++corner) {
      std::memcpy(vertices[corner], look.vertices[corner], sizeof(vertices[corner]));
    }
    look.hit->most = MostOf(*look.hit->ray, vertices);
  }
}

}  // namespace dacrt::mpi
