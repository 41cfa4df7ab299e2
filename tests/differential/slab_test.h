// What rounding may do to the real library's bounding-box tests.
#pragma once

#include <embree3/rtcore.h>

#include <limits>
#include <span>

#include "company.h"
#include "motion.h"

namespace dacrt::tests {

/// A bounding box, and how far a library's planes may be from it.
struct SlabBox {
  double lower[3], upper[3];
  double plane_error[3] = {};

  SlabBox() {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::numeric_limits<double>::infinity();
      upper[axis] = -std::numeric_limits<double>::infinity();
    }
  }

  void Extend(const Approximate3& center, const Approximate& radius);
};

/// Whether single-precision slab tests may find that the ray misses the box, if each distance is
/// off by its rounding error. `packet` are the rays, this one included, that may be tested
/// together by the intervals of their origins and reciprocal directions: then the largest of them
/// make the error. Alone if it is empty. A box around this one, as those of a hierarchy are, is
/// lost only if this one may be: the float distance to a plane is monotone in the plane.
bool SlabTestMayMiss(const ApproximateRay& ray, double tfar, const SlabBox& box,
                     std::span<const RTCRayHit> packet);

/// Whether a box around this one, and not around more than `all`, may be lost where the real
/// library measures with the box itself, as it does with points: a ray's direction is divided by
/// the box's lengths, and components that are then less than 1e-18 are taken for that, towards
/// either side of the axis.
bool OwnSpaceTestMayMiss(const ApproximateRay& ray, const SlabBox& box, const SlabBox& all);

}  // namespace dacrt::tests
