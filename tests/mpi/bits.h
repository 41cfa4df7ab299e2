// Answers of several ranks beside those of one process, bit for bit.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <span>

#include "rays.h"
#include "streams.h"

namespace dacrt::tests {

/// The number of the first record that differs; the number of records if none does.
inline std::size_t FirstDifference(std::span<const RTCRayHit> a, std::span<const RTCRayHit> b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof(RTCRayHit)) != 0) return i;
  }
  return a.size();
}

/// Fails with the first record that differs.
inline void ExpectSame(std::span<const RTCRayHit> before, std::span<const RTCRayHit> one,
                       std::span<const RTCRayHit> several) {
  ASSERT_EQ(one.size(), several.size());
  const std::size_t i = FirstDifference(one, several);
  if (i == one.size()) return;
  std::size_t count = 0;
  for (std::size_t k = i; k < one.size(); ++k) {
    count += std::memcmp(&one[k], &several[k], sizeof(RTCRayHit)) != 0;
  }
  const RTCRay& ray = before[i].ray;
  ADD_FAILURE() << count << " of " << one.size() << " records differ, first " << i << ": from ("
                << ray.org_x << ", " << ray.org_y << ", " << ray.org_z << ") along (" << ray.dir_x
                << ", " << ray.dir_y << ", " << ray.dir_z << "), " << ray.tnear << " to "
                << ray.tfar << "; one process t " << one[i].ray.tfar << ", primitive "
                << one[i].hit.primID << " of " << one[i].hit.geomID << "; several t "
                << several[i].ray.tfar << ", primitive " << several[i].hit.primID << " of "
                << several[i].hit.geomID;
}

/// `count` rays of every kind, in one batch.
inline std::vector<RTCRayHit> MixedRays(const RayGenerator& generator, std::size_t count,
                                        uint64_t seed) {
  std::vector<RTCRayHit> rays;
  for (const RayKind kind : AllRayKinds()) {
    const std::vector<RTCRayHit> some = generator.Make(kind, count, seed + rays.size());
    rays.insert(rays.end(), some.begin(), some.end());
  }
  return rays;
}

}  // namespace dacrt::tests
