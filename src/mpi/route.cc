#include "route.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dacrt::mpi {
namespace {

/// By how much bounds are widened, as a part of the numbers in sight on an axis; distances alike.
/// Single precision rounds to less than 2^-24, and a triangle test rounds some ten times.
constexpr double kSlack = 0x1p-18;
/// And by how much at least: the engine widens the box of each triangle by half of it, so that of
/// triangles as small as that hits beside them count.
constexpr double kLeastSlack = 2e-20;

constexpr double kNever = std::numeric_limits<double>::infinity();

// Infinity stays what it is.
double Later(double distance) { return distance * (1 + std::copysign(kSlack, distance)); }
double Earlier(double distance) { return distance * (1 - std::copysign(kSlack, distance)); }

}  // namespace

RouteBoxes::RouteBoxes(std::span<const Bounds> bounds) {
  for (const Bounds& part : bounds) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = part.lower[axis], upper = part.upper[axis];
      const double slack = kSlack * std::max(std::abs(lower), std::abs(upper)) + kLeastSlack;
      box.lower[axis] = lower - slack;
      box.upper[axis] = upper + slack;
    }
    // There is nothing in it: no ray enters what is not a number.
    if (!(part.lower[0] <= part.upper[0])) {
      box.lower[0] = box.upper[0] = std::numeric_limits<double>::quiet_NaN();
    }
    boxes_.push_back(box);
  }
}

void Route::Set(const RouteRay& ray, int home) {
  home_ = home;
  const double start = std::max(ray.tnear, 0.0f);
  // The slack of the origin is that of both faces.
  double reciprocal[3], to_lower[3], to_upper[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double org = ray.org[axis], slack = kSlack * std::abs(org);
    // A ray along a slab is in it from -infinity to infinity, or never.
    reciprocal[axis] = 1 / static_cast<double>(ray.dir[axis]);
    to_lower[axis] = -org - slack;
    to_upper[axis] = -org + slack;
  }
  for (std::size_t rank = 0; rank < entries_.size(); ++rank) {
    const RouteBoxes::Box& box = boxes_.boxes_[rank];
    double first = -kNever, last = kNever;
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = (box.lower[axis] + to_lower[axis]) * reciprocal[axis];
      const double upper = (box.upper[axis] + to_upper[axis]) * reciprocal[axis];
      first = std::max(first, std::min(lower, upper));
      last = std::min(last, std::max(lower, upper));
    }
    const double entry = std::max(start, Earlier(first));
    const bool is_entered = box.lower[0] <= box.upper[0] && entry <= Later(Later(last));
    entries_[rank] = is_entered ? entry : kNever;
  }
}

int Route::Next(float limit, int last) const {
  const int ranks = static_cast<int>(entries_.size());
  const double latest = Later(limit);
  const auto stop = [&](int rank) {
    return std::pair(entries_[static_cast<std::size_t>(rank)], (rank - home_ + ranks) % ranks);
  };
  const auto none = std::pair(kNever, 0);
  const auto after = last == kNew ? std::pair(-1.0, -1) : stop(last);
  auto next = none;
  for (int rank = 0; rank < ranks; ++rank) {
    if (!(entries_[static_cast<std::size_t>(rank)] <= latest)) continue;
    const auto candidate = stop(rank);
    if (candidate > after && candidate < next) next = candidate;
  }
  return next == none ? kNowhere : (next.second + home_) % ranks;
}

}  // namespace dacrt::mpi
