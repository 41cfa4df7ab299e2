// Reading a record after a query.
#pragma once

#include <cstring>
#include <limits>

#include "streams.h"

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

}  // namespace dacrt::tests
