// Axis-aligned boxes in the form that the partition works with.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace dacrt {

/// Beyond, products of coordinates overflow. What reaches 1.844e18 is left out, by Embree as well.
inline constexpr float kLargestCoordinate =
    std::bit_cast<float>(std::bit_cast<uint32_t>(1.844e18f) - 1);

/// Whether no coordinate of a corner is too large, infinite, or not a number.
inline bool IsUsable(const float* corner) {
  // So that a coordinate which is not a number fails as well.
  return std::abs(corner[0]) <= kLargestCoordinate && std::abs(corner[1]) <= kLargestCoordinate &&
         std::abs(corner[2]) <= kLargestCoordinate;
}

/// Four floats a corner, so that a corner is one 16-byte vector; the fourth has no meaning.
struct alignas(16) Box {
  float lower[4];
  float upper[4];

  static Box Empty() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    return {{kInfinity, kInfinity, kInfinity, 0}, {-kInfinity, -kInfinity, -kInfinity, 0}};
  }

  void Extend(const float* point) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], point[axis]);
      upper[axis] = std::max(upper[axis], point[axis]);
    }
  }

  void Extend(const Box& other) {
    Extend(other.lower);
    Extend(other.upper);
  }

  bool IsEmpty() const { return !(lower[0] <= upper[0]); }

  /// Not above 0 if empty.
  float LongestSide() const {
    return std::max({upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]});
  }

  /// Half of the surface, which is all that ratios of surfaces need. 0 if empty.
  float HalfArea() const {
    if (IsEmpty()) return 0;
    const float x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    return x * y + y * z + z * x;
  }

  /// What half the surface of a box within it is times this is at most about 1, so that the sum of
  /// many is finite, wherever the box lies. 1 if the surface is next to nothing, or beyond all
  /// numbers.
  float SurfaceScale() const {
    const float area = HalfArea();
    return area > 1e-37f && area <= std::numeric_limits<float>::max() ? 1 / area : 1;
  }
};

}  // namespace dacrt
