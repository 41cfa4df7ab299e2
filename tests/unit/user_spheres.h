// User primitives of tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "dacrt/dacrt.h"
#include "unit_test.h"

namespace dacrt::unit {

/// A sphere of radius 0.1 around a point for each user primitive; no state but the points.
struct UserSpheres {
  static constexpr float kRadius = 0.1f;

  static void Bound(void* data, uint32_t primitive, uint32_t, Bounds& bounds) {
    const Float3& center = static_cast<const Float3*>(data)[primitive];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.lower[axis] = center[axis] - kRadius;
      bounds.upper[axis] = center[axis] + kRadius;
    }
  }

  static void Intersect(void* data, const CallbackArguments& arguments) {
    using enum PacketComponent;
    const Float3& center = static_cast<const Float3*>(data)[arguments.primitive_id];
    const auto at = [&](PacketComponent component, std::size_t lane) -> float& {
      return static_cast<float*>(
          arguments.packet)[static_cast<std::size_t>(component) * arguments.width + lane];
    };
    for (std::size_t lane = 0; lane < arguments.width; ++lane) {
      if (!arguments.valid[lane]) continue;
      float b = 0, c = 0, d2 = 0;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const float to = center[axis] - at(static_cast<PacketComponent>(axis), lane);
        const float dir = at(static_cast<PacketComponent>(4 + axis), lane);
        b += to * dir;
        c += to * to;
        d2 += dir * dir;
      }
      b /= d2;
      const float half2 = kRadius * kRadius / d2 - (c / d2 - b * b);
      if (half2 < 0) continue;
      const float t = b - std::sqrt(half2);
      if (t <= at(kTnear, lane) || t < 0 || t > at(kTfar, lane)) continue;
      if (arguments.query == Query::kAny) {
        at(kTfar, lane) = -kInfinity;
        continue;
      }
      at(kTfar, lane) = t;
      const auto put = [&](PacketComponent component, uint32_t value) {
        std::memcpy(&at(component, lane), &value, sizeof(value));
      };
      for (const PacketComponent normal : {kNgX, kNgY, kNgZ}) at(normal, lane) = 1;
      at(kU, lane) = at(kV, lane) = 0;
      put(kPrimitiveId, arguments.primitive_id);
      put(kGeometryId, arguments.geometry_id);
      put(kInstanceId, arguments.instance_id);
    }
  }

  /// `centers` must stay in place.
  static Geometry Of(const std::vector<Float3>& centers, uint32_t id) {
    Geometry geometry;
    geometry.shape = Shape::kUser;
    geometry.geometry_id = id;
    geometry.primitive_count = centers.size();
    geometry.bounds = {Bound, const_cast<Float3*>(centers.data())};
    geometry.intersect = geometry.occluded = {Intersect, geometry.bounds.data};
    return geometry;
  }
};

}  // namespace dacrt::unit
