// What tests of point queries share.
#pragma once

#include <array>

#include "session.h"

namespace dacrt::tests {

/// Twelve numbers as RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR has them.
using Matrix = std::array<float, 12>;

inline RTCPointQuery QueryAt(const std::array<double, 3>& p, float radius, float time = 0) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), time,
          radius};
}

inline bool Query(const Api& api, RTCScene scene, RTCPointQuery& query,
                  RTCPointQueryFunction function, void* user_pointer) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const bool changed = api.rtcPointQuery(scene, &query, &context, function, user_pointer);
  EXPECT_EQ(context.instStackSize, 0u);
  EXPECT_EQ(context.instID[0], RTC_INVALID_GEOMETRY_ID);
  return changed;
}

class PointQueryTest : public OnBothLibraries {
 protected:
  bool IsOurs() const { return &s_.api == &DropIn(); }

  Session s_{GetParam()()};
};

}  // namespace dacrt::tests
