// The domain of a point query: what lies within a radius of a point, seen from a scene's space.
#pragma once

#include <algorithm>

#include "dacrt/transform.h"

namespace dacrt {

/// A ball, or where the way to the scene's space makes it an ellipsoid, a box that holds it. Wide
/// enough for the rounding of the way there and of distances.
class PointDomain {
 public:
  /// `to_scene` leads from the space of point and radius to the scene's; null if they are the same.
  PointDomain(const AffineTransform* to_scene, const float* point);

  /// False if the point, as the scene sees it, is not a number.
  bool IsValid() const;

  void SetRadius(float radius);

  const float* center() const { return center_; }

  /// How far the domain reaches on each axis; and the largest squared distance in it.
  const float* reach() const { return reach_; }
  float square() const { return square_; }

  /// Whether a box has a part in the domain.
  bool Meets(const float* lower, const float* upper) const {
    float square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float distance =
          std::max(std::max(lower[axis] - center_[axis], center_[axis] - upper[axis]), 0.0f);
      if (!(distance <= reach_[axis])) return false;
      square += distance * distance;
    }
    return square <= square_;
  }

 private:
  float center_[3];
  float error_ = 0;  ///< of the centre
  float scale_[3] = {1, 1, 1};
  bool is_ball_ = true;
  float reach_[3] = {};
  float square_ = 0;
};

}  // namespace dacrt
