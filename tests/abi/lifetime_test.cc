// How long objects live: as long as the program or another object refers to them. A sanitizer's
// build finds what these tests leave behind or use too late.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

constexpr unsigned int kMiss = RTC_INVALID_GEOMETRY_ID;

class Lifetime : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Lifetime);

/// The handles of a committed scene, of each of which the program holds one reference.
struct Handles {
  explicit Handles(const Api& api) {
    device = api.rtcNewDevice(nullptr);
    buffer = api.rtcNewBuffer(device, 48);
    auto* const vertices = static_cast<float*>(api.rtcGetBufferData(buffer));
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::copy(corners, corners + 9, vertices);
    geometry = api.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    api.rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, 0, 12,
                             3);
    auto* const indices = static_cast<unsigned int*>(
        api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, 1));
    for (unsigned int i = 0; i < 3; ++i) indices[i] = i;
    api.rtcCommitGeometry(geometry);
    scene = api.rtcNewScene(device);
    api.rtcAttachGeometry(scene, geometry);
    api.rtcCommitScene(scene);
  }

  RTCDevice device;
  RTCBuffer buffer;
  RTCGeometry geometry;
  RTCScene scene;
};

unsigned int Trace(const Api& api, RTCScene scene) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = RayAt(0.2f);
  api.rtcIntersect1M(scene, &context, &ray, 1, sizeof ray);
  return ray.hit.geomID;
}

TEST_P(Lifetime, EveryReleaseOrderWorks) {
  const Api& api = GetParam()();
  std::vector<int> order = {0, 1, 2, 3};
  do {
    const Handles handles(api);
    for (const int object : order) {
      switch (object) {
        case 0:
          api.rtcReleaseDevice(handles.device);
          break;
        case 1:
          api.rtcReleaseBuffer(handles.buffer);
          break;
        case 2:
          api.rtcReleaseGeometry(handles.geometry);
          break;
        case 3:
          // Whatever else the program has released, the scene has kept what it needs.
          EXPECT_EQ(Trace(api, handles.scene), 0u);
          api.rtcReleaseScene(handles.scene);
          break;
      }
    }
    EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_P(Lifetime, RetainedHandlesOutliveARelease) {
  const Api& api = GetParam()();
  const Handles handles(api);
  api.rtcRetainScene(handles.scene);
  api.rtcRetainGeometry(handles.geometry);
  api.rtcRetainBuffer(handles.buffer);
  api.rtcRetainDevice(handles.device);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(Trace(api, handles.scene), 0u);
    EXPECT_NE(api.rtcGetBufferData(handles.buffer), nullptr);
    EXPECT_EQ(api.rtcGetDeviceError(handles.device), RTC_ERROR_NONE);
    api.rtcReleaseScene(handles.scene);
    api.rtcReleaseGeometry(handles.geometry);
    api.rtcReleaseBuffer(handles.buffer);
    api.rtcReleaseDevice(handles.device);
  }
}

TEST_P(Lifetime, AttachedGeometryKeepsItsHandle) {
  const Api& api = GetParam()();
  const Handles handles(api);
  api.rtcReleaseGeometry(handles.geometry);
  api.rtcSetGeometryMask(handles.geometry, 0);
  api.rtcCommitGeometry(api.rtcGetGeometry(handles.scene, 0));
  api.rtcCommitScene(handles.scene);
  EXPECT_EQ(Trace(api, handles.scene), kMiss);
  // A reference can be taken again.
  api.rtcRetainGeometry(api.rtcGetGeometry(handles.scene, 0));
  api.rtcDetachGeometry(handles.scene, 0);
  EXPECT_EQ(api.rtcGetGeometryUserData(handles.geometry), nullptr);
  api.rtcReleaseGeometry(handles.geometry);
  EXPECT_EQ(api.rtcGetDeviceError(handles.device), RTC_ERROR_NONE);
  api.rtcReleaseScene(handles.scene);
  api.rtcReleaseBuffer(handles.buffer);
  api.rtcReleaseDevice(handles.device);
}

// The real library answers these with memory errors.

TEST(DropInLifetime, ReleasedHandlesAreRefused) {
  const Api& api = DropIn();
  const Handles handles(api);
  api.rtcReleaseScene(handles.scene);
  api.rtcReleaseGeometry(handles.geometry);
  api.rtcReleaseBuffer(handles.buffer);
  api.rtcReleaseDevice(handles.device);
  RTCBounds bounds;
  const std::function<void()> calls[] = {
      [&] { api.rtcCommitScene(handles.scene); },
      [&] { api.rtcReleaseScene(handles.scene); },
      [&] { api.rtcRetainScene(handles.scene); },
      [&] { api.rtcGetSceneBounds(handles.scene, &bounds); },
      [&] { EXPECT_EQ(api.rtcAttachGeometry(handles.scene, handles.geometry), kMiss); },
      [&] { EXPECT_EQ(api.rtcGetGeometryThreadSafe(handles.scene, 0), nullptr); },
      [&] { api.rtcCommitGeometry(handles.geometry); },
      [&] { api.rtcReleaseGeometry(handles.geometry); },
      [&] { EXPECT_EQ(api.rtcGetBufferData(handles.buffer), nullptr); },
      [&] { api.rtcReleaseBuffer(handles.buffer); },
      [&] { EXPECT_EQ(api.rtcNewScene(handles.device), nullptr); },
      [&] { api.rtcReleaseDevice(handles.device); },
  };
  for (const auto& call : calls) {
    call();
    EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  }
}

// A handle whose place another one had taken before was not found.
TEST(DropInLifetime, ManyHandlesComeAndGoInAnyOrder) {
  const Api& api = DropIn();
  const RTCDevice device = api.rtcNewDevice(nullptr);
  std::vector<RTCGeometry> alive, gone;
  uint32_t random = 1;
  const auto next = [&](std::size_t below) {
    random = random * 1664525 + 1013904223;
    return static_cast<std::size_t>(random >> 8) % below;
  };
  const auto answers = [&](RTCGeometry geometry) {
    api.rtcSetGeometryMask(geometry, 1);
    return api.rtcGetDeviceError(nullptr) == RTC_ERROR_NONE;
  };
  for (const std::size_t count : {1000u, 10u, 300u, 0u, 50u, 0u}) {
    while (alive.size() < count) {
      alive.push_back(api.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
      std::erase(gone, alive.back());
    }
    while (alive.size() > count) {
      std::swap(alive[next(alive.size())], alive.back());
      api.rtcReleaseGeometry(alive.back());
      gone.push_back(alive.back());
      alive.pop_back();
    }
    EXPECT_TRUE(std::ranges::all_of(alive, answers)) << count;
    EXPECT_TRUE(std::ranges::none_of(gone, answers)) << count;
  }
  api.rtcReleaseDevice(device);
}

TEST(DropInLifetime, HandlesOfAnotherTypeAreRefused) {
  const Api& api = DropIn();
  const Handles handles(api);
  api.rtcCommitScene(reinterpret_cast<RTCScene>(handles.geometry));
  EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(api.rtcAttachGeometry(handles.scene, reinterpret_cast<RTCGeometry>(handles.buffer)),
            kMiss);
  EXPECT_EQ(api.rtcGetDeviceError(handles.device), RTC_ERROR_INVALID_ARGUMENT);
  api.rtcReleaseScene(handles.scene);
  api.rtcReleaseGeometry(handles.geometry);
  api.rtcReleaseBuffer(handles.buffer);
  api.rtcReleaseDevice(handles.device);
}

TEST(DropInLifetime, OneReleaseTooManyTakesNothingFromTheScene) {
  const Api& api = DropIn();
  const Handles handles(api);
  api.rtcReleaseGeometry(handles.geometry);
  api.rtcReleaseGeometry(handles.geometry);
  EXPECT_EQ(api.rtcGetDeviceError(handles.device), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(api.rtcGetGeometry(handles.scene, 0), handles.geometry);
  EXPECT_EQ(Trace(api, handles.scene), 0u);
  api.rtcReleaseScene(handles.scene);
  api.rtcReleaseBuffer(handles.buffer);
  api.rtcReleaseDevice(handles.device);
}

TEST(DropInLifetime, CommittedSceneKeepsBuffersThatTheGeometryGaveUp) {
  const Api& api = DropIn();
  const Handles handles(api);
  api.rtcSetNewGeometryBuffer(handles.geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                              3);
  api.rtcReleaseBuffer(handles.buffer);
  api.rtcDetachGeometry(handles.scene, 0);
  api.rtcReleaseGeometry(handles.geometry);
  EXPECT_EQ(Trace(api, handles.scene), 0u);
  api.rtcReleaseScene(handles.scene);
  api.rtcReleaseDevice(handles.device);
}

}  // namespace
}  // namespace dacrt::tests
