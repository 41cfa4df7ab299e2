#include "route.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dacrt::mpi {
namespace {

/// By how much bounds are widened, as a part of the largest number in sight on an axis; distances
/// alike. Single precision rounds to less than 2^-24, and a triangle test rounds some ten times.
constexpr double kSlack = 0x1p-18;
/// And by how much at least: the engine widens the box of each triangle by half of it, so that of
/// triangles as small as that hits beside them count.
constexpr double kLeastSlack = 2e-20;

constexpr double kNever = std::numeric_limits<double>::infinity();

/// A ray made ready for the test of many boxes.
struct Slabs {
  explicit Slabs(const RouteRay& ray) : start(std::max(ray.tnear, 0.0f)) {
    for (int axis = 0; axis < 3; ++axis) {
      org[axis] = ray.org[axis];
      // A ray along a slab is in it from -infinity to infinity, or never.
      reciprocal[axis] = 1 / static_cast<double>(ray.dir[axis]);
    }
  }
  double org[3], reciprocal[3], start;
};

// Infinity stays what it is.
double Later(double distance) { return distance * (distance > 0 ? 1 + kSlack : 1 - kSlack); }
double Earlier(double distance) { return distance * (distance > 0 ? 1 - kSlack : 1 + kSlack); }

/// Where a ray enters `box`, at its own start at the earliest; kNever if it does not within
/// `limit`.
double Entry(const Bounds& box, const Slabs& ray, double limit) {
  if (!(box.lower[0] <= box.upper[0])) return kNever;  // there is nothing in it
  double entry = ray.start, exit = limit;
  for (int axis = 0; axis < 3; ++axis) {
    const double size =
        std::max({std::abs(static_cast<double>(box.lower[axis])),
                  std::abs(static_cast<double>(box.upper[axis])), std::abs(ray.org[axis])});
    const double slack = kSlack * size + kLeastSlack;
    double begin = (box.lower[axis] - slack - ray.org[axis]) * ray.reciprocal[axis];
    double end = (box.upper[axis] + slack - ray.org[axis]) * ray.reciprocal[axis];
    if (begin > end) std::swap(begin, end);
    entry = std::max(entry, Earlier(begin));
    exit = std::min(exit, Later(end));
  }
  // Also false for what is not a number.
  return entry <= Later(exit) ? entry : kNever;
}

}  // namespace

int NextRank(std::span<const Bounds> bounds, const RouteRay& ray, int home, int last) {
  const int ranks = static_cast<int>(bounds.size());
  const Slabs slabs(ray);
  const auto stop = [&](int rank) {
    // Without the limit for the last one: it may have become smaller there.
    const double limit = rank == last ? kNever : ray.limit;
    return std::pair(Entry(bounds[static_cast<std::size_t>(rank)], slabs, limit),
                     (rank - home + ranks) % ranks);
  };
  const auto none = std::pair(kNever, 0);
  const auto after = last == kNew ? std::pair(-1.0, -1) : stop(last);
  auto next = none;
  for (int rank = 0; rank < ranks; ++rank) {
    const auto candidate = stop(rank);
    if (candidate > after && candidate < next) next = candidate;
  }
  return next == none ? kNowhere : (next.second + home) % ranks;
}

}  // namespace dacrt::mpi
