#include "geometry/instance_bounds.h"

#include <algorithm>
#include <cmath>

namespace dacrt {
namespace {

/// The box of a transformed box, wide enough for the rounding of rays that are transformed back.
Box TransformBox(const AffineTransform& transform, const Box& box) {
  Box out = Box::Empty();
  for (int axis = 0; axis < 3; ++axis) {
    double lower = transform.column[3][axis], upper = lower, size = std::abs(lower);
    for (int i = 0; i < 3; ++i) {
      const double a = double{transform.column[i][axis]} * box.lower[i];
      const double b = double{transform.column[i][axis]} * box.upper[i];
      lower += std::min(a, b);
      upper += std::max(a, b);
      size += std::max(std::abs(a), std::abs(b));
    }
    constexpr double kSlack = 0x1p-20;
    out.lower[axis] = static_cast<float>(lower - kSlack * size);
    out.upper[axis] = static_cast<float>(upper + kSlack * size);
  }
  return out;
}

/// A rotation takes each point of a box no further from the origin than it was: bounds of the
/// instance between two steps that are in parts.
Box BoundRotation(const TransformStep& a, const TransformStep& b, const Box& box) {
  double radius = 0;
  Box translations = Box::Empty();
  for (const TransformStep* step : {&a, &b}) {
    TransformStep still = *step;
    for (int i = 0; i < 4; ++i) still.parts.quaternion[i] = i == 0;
    for (float& value : still.parts.translation) value = 0;
    const Box scaled = TransformBox(TransformAt({&still, 1}, {}, 0), box);
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double far = std::max(std::abs(scaled.lower[axis]), std::abs(scaled.upper[axis]));
      square += far * far;
    }
    radius = std::max(radius, std::sqrt(square));
    translations.Extend(step->parts.translation);
  }
  // It can be far wider than the way is: no wider than surfaces can be taken of.
  constexpr double kFarthest = 2 * double{kLargestCoordinate};
  Box out = translations;
  for (int axis = 0; axis < 3; ++axis) {
    out.lower[axis] =
        static_cast<float>(std::max(-kFarthest, double{out.lower[axis]} - radius * (1 + 0x1p-20)));
    out.upper[axis] =
        static_cast<float>(std::min(kFarthest, double{out.upper[axis]} + radius * (1 + 0x1p-20)));
  }
  return out;
}

}  // namespace

void BoundInstance(std::span<const TransformStep> transforms, const Box& box, Box* bounds) {
  std::fill_n(bounds, transforms.size(), Box::Empty());
  for (std::size_t i = 0; i < transforms.size() && !box.IsEmpty(); ++i) {
    const Box at_step = TransformBox(TransformAt(transforms.subspan(i, 1), {}, 0), box);
    if (!IsUsable(at_step.lower) || !IsUsable(at_step.upper)) continue;
    bounds[i].Extend(at_step);
    if (i == 0 || !transforms[i].in_parts || !transforms[i - 1].in_parts) continue;
    if (bounds[i - 1].IsEmpty()) continue;
    const Box between = BoundRotation(transforms[i - 1], transforms[i], box);
    bounds[i - 1].Extend(between);
    bounds[i].Extend(between);
  }
}

AffineTransform ToFirstStep(std::span<const TransformStep> transforms) {
  return Inverse(TransformAt(transforms.first(1), {}, 0));
}

}  // namespace dacrt
