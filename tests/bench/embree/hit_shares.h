// Whether the two libraries found the same hits.
#pragma once

#include <cstddef>
#include <vector>

#include "ray_buffer.h"

namespace dacrt::bench {

/// What one library answered, to hold the other's answer against.
class HitShares {
 public:
  /// Remembers the hits of traced rays.
  HitShares(Query query, const RayBuffer& rays);

  /// Of the rays that hit something.
  double hits() const { return hits_; }

  /// Of the same rays, traced again: those with the same answer. Distances that differ by less
  /// than a thousandth are the same.
  double Equal(const RayBuffer& rays) const;

  /// Throws Disagreement (errors.h) unless all rays but a thousandth, which edges and ties may
  /// decide, have the same answer.
  void Check(const RayBuffer& rays) const;

 private:
  Query query_;
  std::vector<float> distances_;  ///< infinite: nothing was hit; negative: occluded
  double hits_;
};

}  // namespace dacrt::bench
