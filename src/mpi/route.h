// Where a ray goes next: to the ranks whose bounds it enters, nearest first.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dacrt/geometry.h"

namespace dacrt::mpi {

/// A ray on its way. `limit` is the distance beyond which no hit counts any more.
struct RouteRay {
  float org[3], dir[3];
  float tnear, limit;
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
  friend class Route;
  struct Box {
    double lower[3], upper[3];
  };
  std::vector<Box> boxes_;
};

/// The ranks that a ray enters. All ranks find the same.
class Route {
 public:
  explicit Route(const RouteBoxes& boxes) : boxes_(boxes), entries_(boxes.size()) {}

  /// From now on of this ray, of rank `home`.
  void Set(const RouteRay& ray, int home);

  /// The rank that the ray visits after `last`: of those whose bounds it enters within `limit`, the
  /// one that it enters next; those entered at the same distance in the order of ranks from home
  /// on. Each is visited once, whatever the limit becomes on the way.
  int Next(float limit, int last) const;

 private:
  const RouteBoxes& boxes_;
  std::vector<double> entries_;  ///< where the ray enters what each rank has
  int home_ = 0;
};

}  // namespace dacrt::mpi
