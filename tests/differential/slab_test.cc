#include "slab_test.h"

#include <algorithm>
#include <cmath>

namespace dacrt::tests {

void SlabBox::Extend(const Approximate3& center, const Approximate& radius) {
  for (int axis = 0; axis < 3; ++axis) {
    const double value = center[axis].value;
    lower[axis] = std::min(lower[axis], value - radius.value);
    upper[axis] = std::max(upper[axis], value + radius.value);
    // Centre and radius are added in single precision.
    const double sum = IsZero(radius) ? 0 : kUnitRoundoff * (std::abs(value) + Magnitude(radius));
    plane_error[axis] = std::max(plane_error[axis], center[axis].error + radius.error + sum);
  }
}

bool SlabTestMayMiss(const ApproximateRay& ray, double tfar, const SlabBox& box,
                     std::span<const RTCRayHit> packet) {
  Approximate near[4] = {{std::max(0.0, ray.tnear), 0}};
  Approximate far[4] = {{tfar, 0}};
  bool planes_are_exact = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double direction = ray.dir[axis].value, direction_error = ray.dir[axis].error;
    const double origin = ray.org[axis].value;
    const double reciprocal = EmbreeReciprocal(direction);
    // The real library's reciprocals lose this sign, by which it orders the planes.
    if (direction < 0 && reciprocal == -kLargestReciprocal) return true;
    // A library's ray may be parallel to the planes, or go the other way.
    if (direction_error > 0 && std::abs(direction) <= 2 * direction_error) return true;
    double largest_origin = std::abs(origin), largest_reciprocal = std::abs(reciprocal);
    for (const RTCRayHit& other : packet) {
      if (!IsTraced(other.ray)) continue;
      largest_origin = std::max<double>(largest_origin, std::abs((&other.ray.org_x)[axis]));
      largest_reciprocal =
          std::max(largest_reciprocal, std::abs(EmbreeReciprocal((&other.ray.dir_x)[axis])));
    }
    const double inherited = ray.org[axis].error + box.plane_error[axis];
    planes_are_exact = planes_are_exact && inherited == 0 && direction_error == 0;
    // (plane - origin) * reciprocal, or with fused multiply-add plane * reciprocal - origin *
    // reciprocal, where the second product is rounded on its own.
    const auto distance = [&](double plane) {
      const double from_direction =
          direction_error > 0 ? 2 * direction_error / std::abs(direction) : 0;
      const double error =
          (RoundingOf(kQuotientOperations + 1) + from_direction) * std::abs(plane - origin) +
          RoundingOf(1) * largest_origin + inherited;
      return Approximate{(plane - origin) * reciprocal, error * largest_reciprocal};
    };
    near[axis + 1] = distance(reciprocal < 0 ? box.upper[axis] : box.lower[axis]);
    far[axis + 1] = distance(reciprocal < 0 ? box.lower[axis] : box.upper[axis]);
  }
  for (int n = 0; n < 4; ++n) {
    for (int f = 0; f < 4; ++f) {
      // One axis does not lose a single ray on its own: its two planes' distances have the same
      // error in the same order.
      if (n == f && packet.empty() && planes_are_exact) continue;
      if (!(near[n].value + near[n].error <= far[f].value - far[f].error)) return true;
    }
  }
  return false;
}

bool OwnSpaceTestMayMiss(const ApproximateRay& ray, const SlabBox& box, const SlabBox& all) {
  // The place of the origin in the box is a sum of products.
  constexpr int kOperations = 8;
  double error[3], entry[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = ray.org[axis].value;
    error[axis] =
        RoundingOf(kOperations) *
            (std::abs(origin) + std::max(std::abs(all.lower[axis]), std::abs(all.upper[axis]))) +
        ray.org[axis].error + box.plane_error[axis];
    const double reciprocal = EmbreeReciprocal(ray.dir[axis].value);
    const double plane = reciprocal < 0 ? box.upper[axis] : box.lower[axis];
    entry[axis] = (plane - origin) * reciprocal + error[axis] * std::abs(reciprocal);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double length = all.upper[axis] - all.lower[axis];
    const double least_direction = std::abs(ray.dir[axis].value) - ray.dir[axis].error;
    if (least_direction * kLargestReciprocal >= length) continue;
    const double origin = ray.org[axis].value;
    const double way = std::min(box.upper[axis] - origin, origin - box.lower[axis]) - error[axis];
    const double exit = way / length * kLargestReciprocal;
    // By the planes of the other axes a larger box is entered no later.
    if (exit < std::max({0.0, ray.tnear, entry[(axis + 1) % 3], entry[(axis + 2) % 3]}))
      return true;
  }
  return false;
}

}  // namespace dacrt::tests
