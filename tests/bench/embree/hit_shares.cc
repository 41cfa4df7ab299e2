#include "hit_shares.h"

#include <algorithm>
#include <cmath>

#include "errors.h"
#include "format.h"

namespace dacrt::bench {
namespace {

float DistanceOf(Query query, const RayRecord& ray) {
  if (query == Query::kAny) return ray.tfar < 0 ? -1 : kInfinity;
  return ray.geometry_id == kNoGeometry ? kInfinity : ray.tfar;
}

bool IsSame(float a, float b) {
  constexpr float kTolerance = 1e-3f;
  return a == b || std::abs(a - b) <= kTolerance * std::min(std::abs(a), std::abs(b));
}

double Share(std::size_t some, std::size_t all) {
  return all == 0 ? 1 : static_cast<double>(some) / all;
}

}  // namespace

HitShares::HitShares(Query query, const RayBuffer& rays) : query_(query) {
  distances_.reserve(rays.rays().size());
  for (const RayRecord& ray : rays.rays()) distances_.push_back(DistanceOf(query, ray));
  const auto misses = std::ranges::count(distances_, kInfinity);
  hits_ = Share(distances_.size() - misses, distances_.size());
}

double HitShares::Equal(const RayBuffer& rays) const {
  std::size_t equal = 0;
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    equal += IsSame(distances_[i], DistanceOf(query_, rays.rays()[i]));
  }
  return Share(equal, distances_.size());
}

void HitShares::Check(const RayBuffer& rays) const {
  constexpr double kLeastEqual = 0.999;
  const double equal = Equal(rays);
  // A few rays decide nothing.
  if ((1 - equal) * distances_.size() <= 1 || equal >= kLeastEqual) return;
  throw Disagreement("only " + Fixed(100 * equal, 2) + " % of " + Grouped(distances_.size()) +
                     " rays get the same answer from Embree and from dacrt");
}

}  // namespace dacrt::bench
