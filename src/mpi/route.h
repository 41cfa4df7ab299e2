// Where a ray goes next: to the ranks whose bounds it enters, nearest first.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "dacrt/geometry.h"

namespace dacrt::mpi {

/// A ray on its way.
struct RouteRay {
  float org[3], dir[3];
  float tnear;
  int home;  ///< the rank whose ray it is
};

/// There is no rank where the ray may still hit something.
inline constexpr int kNowhere = -1;
/// In the place of the last rank: the ray has been nowhere yet.
inline constexpr int kNew = -1;

/// The bounds of the ranks' parts, made ready for many rays. They count as a little wider than they
/// are, so that no rank is skipped where its engine would find a hit.
class RouteBoxes {
 public:
  explicit RouteBoxes(std::span<const Bounds> bounds);

  std::size_t size() const { return boxes_.size(); }

 private:
  friend class Routes;
  struct Box {
    float lower[3], upper[3];
    bool is_empty;
  };
  std::vector<Box> boxes_;
};

namespace routes {

/// By how much bounds are widened, as a part of the numbers in sight on an axis; distances alike.
/// Single precision rounds to less than 2^-24, a triangle test rounds some ten times, and what is
/// done here another few.
inline constexpr float kSlack = 0x1p-18f;

inline float Later(float distance) { return distance * (1 + std::copysign(kSlack, distance)); }

}  // namespace routes

/// A rank that a ray visits.
struct Stop {
  int rank;
  float entry;  ///< where the ray enters what the rank has

  /// Whether a hit there counts.
  bool IsWithin(float limit) const { return rank != kNowhere && entry <= routes::Later(limit); }

  /// The rank if it is within `limit`, else kNowhere.
  int RankWithin(float limit) const { return IsWithin(limit) ? rank : kNowhere; }
};

/// The ranks that each of some rays enters. All ranks find the same.
class Routes {
 public:
  /// Rays that are looked at together.
  static constexpr std::size_t kMost = 64;

  explicit Routes(const RouteBoxes& boxes) : boxes_(boxes), entries_(boxes.size()) {}

  /// The rays, kMost at most: Add each, then Find.
  void Add(const RouteRay& ray) {
    for (int axis = 0; axis < 3; ++axis) {
      orgs_[axis][count_] = ray.org[axis];
      dirs_[axis][count_] = ray.dir[axis];
    }
    tnears_[count_] = ray.tnear;
    homes_[count_++] = ray.home;
  }
  void Find();

  /// The rank that ray i of these visits after `last`: of those whose bounds it enters, the one
  /// that it enters next; those entered at the same distance in the order of ranks from home on.
  /// With one that is not within the ray's limit, or kNowhere, its way ends. Each is visited once,
  /// whatever the limit becomes on the way.
  Stop Next(std::size_t i, int last) const;

 private:
  using Row = std::array<float, kMost>;  ///< a value of each ray

  const RouteBoxes& boxes_;
  std::vector<Row> entries_;  ///< by rank
  std::size_t count_ = 0;     ///< since the last Find
  Row orgs_[3]{}, dirs_[3]{}, tnears_{};
  std::array<int, kMost> homes_{};
};

}  // namespace dacrt::mpi
