// Small triangles, far away and nearly parallel to the rays that come to them: where these meet
// them is off by more than the triangles' boxes are deep.
#pragma once

#include <cmath>
#include <cstddef>

#include "unit_test.h"

namespace dacrt::unit {

/// A thin slab far away that contains the way to it from `org`: squeezed along a normal of it.
class GrazedSlab {
 public:
  explicit GrazedSlab(Random& random)
      : random_(random),
        distance_(std::exp2(random.Uniform(4, 12))),
        size_(std::exp2(random.Uniform(-8, 0))),
        flatness_(std::exp2(random.Uniform(-16, -8))),
        org_(random.InCube(-1, 1)),
        way_(random.Direction()),
        normal_(random.Direction()) {
    const float along = Dot(normal_, way_);
    for (std::size_t axis = 0; axis < 3; ++axis) normal_[axis] -= along * way_[axis];
  }

  /// Anywhere in it.
  Float3 Point() {
    Float3 point = random_.InCube(-size_, size_);
    const float height = (1 - flatness_) * Dot(point, normal_) / Dot(normal_, normal_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      point[axis] += org_[axis] + distance_ * way_[axis] - height * normal_[axis];
    }
    return point;
  }

  /// One that meets it at about t = 1.
  Ray MakeGrazingRay() {
    Float3 dir = Point();
    for (std::size_t axis = 0; axis < 3; ++axis) dir[axis] -= org_[axis];
    return MakeRay(org_, dir);
  }

 private:
  static float Dot(const Float3& a, const Float3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }

  Random& random_;
  const float distance_, size_, flatness_;
  const Float3 org_, way_;
  Float3 normal_;
};

}  // namespace dacrt::unit
