// Reading two libraries' records after a query, and judging them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "compare.h"

namespace dacrt::tests {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Sixteen ulp of 1.0, which Embree's own tests allow between its kernels.
inline constexpr double kTolerance = 16 * 0x1p-23;

inline bool SameBits(const RTCRayHit& a, const RTCRayHit& b) {
  return std::memcmp(&a, &b, sizeof(RTCRayHit)) == 0;
}

/// What a record says after a query.
struct Answer {
  bool is_hit = false;
  bool is_legal = true;  ///< nothing changed but what a hit writes
  const RTCRayHit& record;
};

inline Answer Read(Query query, const RTCRayHit& before, const RTCRayHit& after) {
  Answer answer{.record = after};
  if (SameBits(before, after)) return answer;
  answer.is_hit = true;
  RTCRayHit expected = before;
  expected.ray.tfar = after.ray.tfar;
  if (query == Query::kClosest) {
    expected.hit = after.hit;
    answer.is_legal = SameBits(expected, after) && after.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  } else {
    answer.is_legal = SameBits(expected, after) && after.ray.tfar == -kInfinity;
  }
  return answer;
}

/// What a reference says of one library's answer; `Truth` is what it knows of a primitive.
template <typename Truth>
struct JudgementBy {
  std::string fault;                          ///< empty: a correct computation may give this answer
  bool needs_slab_test = false;               ///< it may, if bounding-box tests may lose hits
  std::optional<Truth> truth = std::nullopt;  ///< about the primitive that is named
};

/// Which of two answers to a closest-hit query exact arithmetic gives.
template <typename Truth>
Side SideOfExact(const Answer& real, const JudgementBy<Truth>& of_real, const Answer& drop_in,
                 const JudgementBy<Truth>& of_drop_in) {
  const auto distance = [](const Answer& answer, const JudgementBy<Truth>& judgement) {
    if (!answer.is_hit) return static_cast<double>(kInfinity);
    // A hit that is not one is behind everything.
    return judgement.truth && judgement.truth->is_hit ? judgement.truth->t.value
                                                      : std::numeric_limits<double>::quiet_NaN();
  };
  const double r = distance(real, of_real), d = distance(drop_in, of_drop_in);
  if (std::isnan(r) && std::isnan(d)) return Side::kNeither;
  if (std::isnan(r) || d < r) return Side::kDropIn;
  if (std::isnan(d) || r < d) return Side::kReal;
  return Side::kBoth;
}

/// The reason that the doubts about the named primitives give; the strongest first.
template <typename Truth>
Relation RelationOfDoubts(std::initializer_list<const JudgementBy<Truth>*> judgements) {
  uint32_t doubts = kNoDoubt;
  for (const JudgementBy<Truth>* judgement : judgements) {
    if (judgement->truth) doubts |= judgement->truth->doubts;
  }
  if (doubts & kDoubtRange) return Relation::kRange;
  if (doubts & kDoubtParallel) return Relation::kParallel;
  if (doubts & kDoubtEdge) return Relation::kEdge;
  if (doubts & kDoubtInterval) return Relation::kInterval;
  return Relation::kIllConditioned;
}

/// Where its products overflow the real library takes a hit beyond the end of the ray, and then
/// others that are nearer than that: the ray on which such others are looked for, if there is one
/// of the first kind among all its possible hits.
template <typename Hits>
std::optional<RTCRay> RayBeyondTheEnd(const RTCRay& ray, const Hits& all) {
  const bool any_overflows = std::any_of(all.begin(), all.end(), [](const auto& hit) {
    return (hit.answer.doubts & kDoubtRange) != 0;
  });
  if (!any_overflows) return std::nullopt;
  RTCRay longer = ray;
  longer.tfar = std::numeric_limits<float>::max();
  return longer;
}

inline Comparison Unexplained(std::string reason) {
  return {Relation::kUnexplained, Side::kNeither, std::move(reason)};
}

}  // namespace dacrt::tests
