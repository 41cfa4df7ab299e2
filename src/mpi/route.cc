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

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Where `ray` enters `box`, at its own start at the earliest; kNever if it does not within its
/// limit.
double Entry(const Bounds& box, const RouteRay& ray) {
  double entry = std::max(ray.tnear, 0.0f), exit = ray.limit;
  for (int axis = 0; axis < 3; ++axis) {
    const double org = ray.org[axis], dir = ray.dir[axis];
    const double size = std::max({std::abs(static_cast<double>(box.lower[axis])),
                                  std::abs(static_cast<double>(box.upper[axis])), std::abs(org)});
    const double lower = box.lower[axis] - kSlack * size;
    const double upper = box.upper[axis] + kSlack * size;
    if (dir == 0) {
      if (!(lower <= org && org <= upper)) return kNever;
      continue;
    }
    double begin = (lower - org) / dir, end = (upper - org) / dir;
    if (begin > end) std::swap(begin, end);
    entry = std::max(entry, begin - kSlack * std::abs(begin));
    exit = std::min(exit, end + kSlack * std::abs(end));
  }
  // Also false for what is not a number.
  return entry <= exit + kSlack * std::abs(exit) ? entry : kNever;
}

}  // namespace

int NextRank(std::span<const Bounds> bounds, const RouteRay& ray, int home, int last) {
  const int ranks = static_cast<int>(bounds.size());
  const auto stop = [&](int rank) {
    // Without the limit for the last one: it may have become smaller there.
    RouteRay endless = ray;
    if (rank == last) endless.limit = std::numeric_limits<float>::infinity();
    return std::pair(Entry(bounds[static_cast<std::size_t>(rank)], endless),
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
