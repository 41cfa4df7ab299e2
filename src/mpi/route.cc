#include "route.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dacrt::mpi {
namespace {

/// And by how much at least: the engine widens the box of each triangle by half of it, so that of
/// triangles as small as that hits beside them count.
constexpr float kLeastSlack = 2e-20f;

constexpr float kNever = std::numeric_limits<float>::infinity();

using routes::kSlack;
using routes::Later;

// Infinity stays what it is.
float Earlier(float distance) { return distance * (1 - std::copysign(kSlack, distance)); }

/// Infinity for a ray along a slab, which is in it from -infinity to infinity, or never. Not a
/// number, which says nothing of the ray, where it is too much for a number.
float ReciprocalOf(float component) {
  const float reciprocal = 1 / component;
  const bool is_too_much = component != 0 && std::abs(reciprocal) == kNever;
  return is_too_much ? std::numeric_limits<float>::quiet_NaN() : reciprocal;
}

}  // namespace

RouteBoxes::RouteBoxes(std::span<const Bounds> bounds) {
  for (const Bounds& part : bounds) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      const float lower = part.lower[axis], upper = part.upper[axis];
      const float slack = kSlack * std::max(std::abs(lower), std::abs(upper)) + kLeastSlack;
      box.lower[axis] = lower - slack;
      box.upper[axis] = upper + slack;
    }
    box.is_empty = !(part.lower[0] <= part.upper[0]);
    boxes_.push_back(box);
  }
}

// The inner loops are over rays, for the compiler to do several at once.
void Routes::Find() {
  count_ = 0;
  Row reciprocals[3], to_lower[3], to_upper[3];
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < kMost; ++i) {
      // The slack of the origin is that of both faces.
      const float org = orgs_[axis][i], slack = kSlack * std::abs(org);
      reciprocals[axis][i] = ReciprocalOf(dirs_[axis][i]);
      to_lower[axis][i] = -org - slack;
      to_upper[axis][i] = -org + slack;
    }
  }
  for (std::size_t rank = 0; rank < entries_.size(); ++rank) {
    const RouteBoxes::Box& box = boxes_.boxes_[rank];
    Row& entries = entries_[rank];
    if (box.is_empty) {
      entries.fill(kNever);
      continue;
    }
    Row first, last;
    first.fill(-kNever);
    last.fill(kNever);
    for (int axis = 0; axis < 3; ++axis) {
      const float box_lower = box.lower[axis], box_upper = box.upper[axis];
      for (std::size_t i = 0; i < kMost; ++i) {
        const float lower = (box_lower + to_lower[axis][i]) * reciprocals[axis][i];
        const float upper = (box_upper + to_upper[axis][i]) * reciprocals[axis][i];
        // What is not a number changes nothing.
        first[i] = std::max(first[i], std::min(lower, upper));
        last[i] = std::min(last[i], std::max(lower, upper));
      }
    }
    for (std::size_t i = 0; i < kMost; ++i) {
      const float entry = std::max(std::max(tnears_[i], 0.0f), Earlier(first[i]));
      entries[i] = entry <= Later(Later(last[i])) ? entry : kNever;
    }
  }
}

Stop Routes::Next(std::size_t i, int last) const {
  const int ranks = static_cast<int>(entries_.size());
  const int home = homes_[i];
  const auto entry = [&](int rank) { return entries_[static_cast<std::size_t>(rank)][i]; };
  const auto turn = [&](int rank) { return rank < home ? rank - home + ranks : rank - home; };
  const float last_entry = last == kNew ? -1 : entry(last);
  Stop next{kNowhere, kNever};
  for (int rank = 0; rank < ranks; ++rank) {
    const float candidate = entry(rank);
    if (!(candidate >= last_entry && candidate <= next.entry && candidate < kNever)) continue;
    if (candidate == last_entry && turn(rank) <= turn(last)) continue;
    if (candidate == next.entry && turn(rank) > turn(next.rank)) continue;
    next = {rank, candidate};
  }
  return next;
}

}  // namespace dacrt::mpi
