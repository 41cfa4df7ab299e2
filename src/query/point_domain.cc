#include "query/point_domain.h"

#include <cmath>

namespace dacrt {
namespace {

/// Relative slack of the radius. Distances err by 2^-22, and the scale of a similarity by as much
/// as one may differ from a true one, 2^-17.
constexpr float kSlack = 0x1p-16f;
/// The error of a transformed point, relative to the numbers that it is the sum of.
constexpr float kTransformError = 0x1p-21f;

}  // namespace

PointDomain::PointDomain(const AffineTransform* to_scene, const float* point) {
  std::copy_n(point, 3, center_);
  if (!to_scene) return;
  const float similarity_scale = SimilarityScale(*to_scene);
  is_ball_ = similarity_scale > 0;
  for (int axis = 0; axis < 3; ++axis) {
    float value = to_scene->column[3][axis], size = std::abs(value), length = 0;
    for (int i = 0; i < 3; ++i) {
      const float factor = to_scene->column[i][axis];
      value += factor * point[i];
      size += std::abs(factor * point[i]);
      length = std::hypot(length, factor);
    }
    center_[axis] = value;
    error_ = std::max(error_, kTransformError * size);
    scale_[axis] = is_ball_ ? similarity_scale : length;
  }
}

bool PointDomain::IsValid() const {
  return std::none_of(center_, center_ + 3, [](float value) { return std::isnan(value); });
}

void PointDomain::SetRadius(float radius) {
  square_ = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // The error lies in any direction: sqrt(3) of it, and less than 2.
    reach_[axis] = radius * scale_[axis] * (1 + kSlack) + 2 * error_;
    square_ += reach_[axis] * reach_[axis];
  }
  if (is_ball_) square_ = reach_[0] * reach_[0];
}

}  // namespace dacrt
