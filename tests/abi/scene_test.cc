// Scenes from attaching to re-committing, on both libraries.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

constexpr unsigned int kMiss = RTC_INVALID_GEOMETRY_ID;

class Scene : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Scene);

TEST_P(Scene, AttachTakesTheSmallestFreeId) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  const auto attach = [&] { return s.api.rtcAttachGeometry(scene, s.Triangle()); };
  s.api.rtcAttachGeometryByID(scene, s.Triangle(), 3);
  EXPECT_EQ(attach(), 0u);
  EXPECT_EQ(attach(), 1u);
  EXPECT_EQ(attach(), 2u);
  EXPECT_EQ(attach(), 4u);
  s.api.rtcDetachGeometry(scene, 3);
  s.api.rtcDetachGeometry(scene, 1);
  EXPECT_EQ(attach(), 1u);
  EXPECT_EQ(attach(), 3u);
  EXPECT_EQ(attach(), 5u);
  s.api.rtcDetachGeometry(scene, 0);
  s.api.rtcDetachGeometry(scene, 4);
  EXPECT_EQ(attach(), 0u);
  EXPECT_EQ(attach(), 4u);
}

TEST_P(Scene, FindsGeometriesById) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  const RTCGeometry geometry = s.Triangle();
  s.api.rtcAttachGeometryByID(scene, geometry, 2);
  EXPECT_EQ(s.api.rtcGetGeometry(scene, 2), geometry);
  EXPECT_EQ(s.api.rtcGetGeometryThreadSafe(scene, 2), geometry);
  EXPECT_EQ(s.api.rtcGetGeometry(scene, 1), nullptr);
}

TEST_P(Scene, OneGeometryCanHaveTwoIdsAndTwoScenes) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.Triangle();
  const RTCScene first = s.NewScene();
  EXPECT_EQ(s.api.rtcAttachGeometry(first, geometry), 0u);
  EXPECT_EQ(s.api.rtcAttachGeometry(first, geometry), 1u);
  s.api.rtcCommitScene(first);
  const RTCScene second = s.SceneOf(geometry);
  EXPECT_NE(s.HitGeometry(first), kMiss);
  EXPECT_EQ(s.HitGeometry(second), 0u);
}

TEST_P(Scene, DeviceIsRetainedForTheCaller) {
  const Api& api = GetParam()();
  const RTCDevice device = api.rtcNewDevice(nullptr);
  const RTCScene scene = api.rtcNewScene(device);
  EXPECT_EQ(api.rtcGetSceneDevice(scene), device);
  api.rtcReleaseScene(scene);
  api.rtcReleaseDevice(device);
  EXPECT_EQ(api.rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR), 3);
  api.rtcReleaseDevice(device);
}

TEST_P(Scene, FlagsAreReplaced) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  EXPECT_EQ(s.api.rtcGetSceneFlags(scene), RTC_SCENE_FLAG_NONE);
  s.api.rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  s.api.rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
  EXPECT_EQ(s.api.rtcGetSceneFlags(scene), RTC_SCENE_FLAG_COMPACT);
}

TEST_P(Scene, UserDataComesBack) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.Triangle();
  EXPECT_EQ(s.api.rtcGetGeometryUserData(geometry), nullptr);
  s.api.rtcSetGeometryUserData(geometry, &s);
  EXPECT_EQ(s.api.rtcGetGeometryUserData(geometry), &s);
}

void ExpectBounds(const RTCBounds& bounds, float lower_z, float upper_x, float upper_z) {
  EXPECT_EQ(bounds.lower_x, 0);
  EXPECT_EQ(bounds.lower_y, 0);
  EXPECT_EQ(bounds.lower_z, lower_z);
  EXPECT_EQ(bounds.align0, 0);
  EXPECT_EQ(bounds.upper_x, upper_x);
  EXPECT_EQ(bounds.upper_y, 1);
  EXPECT_EQ(bounds.upper_z, upper_z);
  EXPECT_EQ(bounds.align1, 0);
}

TEST_P(Scene, BoundsAreThoseOfTheEnabledTriangles) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  const RTCGeometry far = s.Triangle(5);
  s.api.rtcAttachGeometry(scene, s.Triangle(-2));
  s.api.rtcAttachGeometry(scene, far);
  s.api.rtcCommitScene(scene);
  RTCBounds bounds;
  s.api.rtcGetSceneBounds(scene, &bounds);
  ExpectBounds(bounds, -2, 1, 5);
  RTCLinearBounds linear_bounds;
  s.api.rtcGetSceneLinearBounds(scene, &linear_bounds);
  ExpectBounds(linear_bounds.bounds0, -2, 1, 5);
  ExpectBounds(linear_bounds.bounds1, -2, 1, 5);

  s.api.rtcDisableGeometry(far);
  s.api.rtcCommitScene(scene);
  s.api.rtcGetSceneBounds(scene, &bounds);
  ExpectBounds(bounds, -2, 1, -2);
}

TEST_P(Scene, EmptyBoundsAreInsideOut) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  s.api.rtcCommitScene(scene);
  RTCBounds bounds;
  s.api.rtcGetSceneBounds(scene, &bounds);
  EXPECT_EQ(bounds.lower_x, INFINITY);
  EXPECT_EQ(bounds.lower_z, INFINITY);
  EXPECT_EQ(bounds.upper_x, -INFINITY);
  EXPECT_EQ(bounds.upper_z, -INFINITY);
  EXPECT_EQ(s.HitGeometry(scene), kMiss);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

TEST_P(Scene, IndicesOutsideTheVerticesAreLeftOut) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.UncommittedTriangle();
  const unsigned int indices[6] = {0, 1, 3, 0, 1, 0xFFFFFFFF};
  s.api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0,
                                   12, 2);
  s.api.rtcCommitGeometry(geometry);
  EXPECT_EQ(s.HitGeometry(s.SceneOf(geometry)), kMiss);
}

TEST_P(Scene, DisabledAndDetachedGeometriesAreNotHit) {
  Session s(GetParam()());
  const RTCGeometry near = s.Triangle(1);
  const RTCScene scene = s.NewScene();
  s.api.rtcAttachGeometry(scene, near);
  s.api.rtcAttachGeometry(scene, s.Triangle(2));
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcDisableGeometry(near);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 1u);
  s.api.rtcEnableGeometry(near);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcDetachGeometry(scene, 0);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 1u);
}

TEST_P(Scene, ChangedVerticesCountOnceCommitted) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.Triangle();
  const RTCScene scene = s.SceneOf(geometry);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  auto* const vertices =
      static_cast<float*>(s.api.rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  for (int i = 0; i < 3; ++i) vertices[4 * i] += 5;
  s.api.rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), kMiss);
  RTCBounds bounds;
  s.api.rtcGetSceneBounds(scene, &bounds);
  EXPECT_EQ(bounds.lower_x, 5);
}

TEST_P(Scene, ChangedIndicesCountOnceCommitted) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.Triangle();
  const RTCScene scene = s.SceneOf(geometry);
  auto* const indices = static_cast<unsigned int*>(
      s.api.rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0));
  indices[2] = 1;
  s.api.rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0);
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), kMiss);
}

TEST_P(Scene, AnotherVertexBufferCountsOnceCommitted) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.Triangle();
  const RTCScene scene = s.SceneOf(geometry);
  auto* const vertices = static_cast<float*>(
      s.api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3));
  for (int i = 0; i < 9; ++i) vertices[i] = 100;
  // The scene still is what was committed, buffers included.
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), kMiss);
}

TEST_P(Scene, MasksDecideWhatIsHit) {
  Session s(GetParam()());
  const RTCGeometry near = s.UncommittedTriangle(1);
  s.api.rtcSetGeometryMask(near, 2);
  s.api.rtcCommitGeometry(near);
  const RTCScene scene = s.NewScene();
  s.api.rtcAttachGeometry(scene, near);
  s.api.rtcAttachGeometry(scene, s.Triangle(2));
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene, 2), 0u);
  EXPECT_EQ(s.HitGeometry(scene, 1), 1u);
  EXPECT_EQ(s.HitGeometry(scene, 0), kMiss);
}

TEST_P(Scene, AttachedGeometriesWaitForTheCommit) {
  Session s(GetParam()());
  const RTCScene scene = s.SceneOf(s.Triangle(1));
  s.api.rtcAttachGeometry(scene, s.Triangle(0));
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 1u);
}

using Progress = std::vector<double>;

bool KeepProgress(void* log, double done) {
  static_cast<Progress*>(log)->push_back(done);
  return true;
}

TEST_P(Scene, ProgressMonitorSeesStartAndEnd) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  s.api.rtcAttachGeometry(scene, s.Triangle());
  Progress log;
  s.api.rtcSetSceneProgressMonitorFunction(scene, KeepProgress, &log);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(log, (Progress{0, 1}));
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(log, (Progress{0, 1})) << "nothing has changed";
}

TEST_P(Scene, ProgressMonitorCanCancel) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  s.api.rtcAttachGeometry(scene, s.Triangle());
  s.api.rtcSetSceneProgressMonitorFunction(
      scene, [](void*, double) { return false; }, nullptr);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_CANCELLED);
  s.api.rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
}

// The real library forgets what was committed before.
TEST(DropInScene, IsAsItWasAfterACommitThatFailed) {
  Session s(DropIn());
  const RTCGeometry geometry = s.Triangle(1);
  const RTCScene scene = s.SceneOf(geometry);
  s.api.rtcAttachGeometry(scene, s.Triangle(0));
  for (const double refused : {0.0, 1.0}) {
    static double refused_progress;
    refused_progress = refused;
    s.api.rtcSetSceneProgressMonitorFunction(
        scene, [](void*, double done) { return done != refused_progress; }, nullptr);
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.TakeError(), RTC_ERROR_CANCELLED);
    EXPECT_EQ(s.HitGeometry(scene), 0u);
  }
  s.api.rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  s.api.rtcSetGeometryMask(geometry, 1);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 1u);
}

// A scene's progress monitor may ask the scene.
TEST(DropInScene, MemoryMonitorIsToldWhatASceneKeepsAndCallsNeed) {
  for (const bool compact : {false, true}) {
    ssize_t held = 0;
    {
      Session s(DropIn());
      s.api.rtcSetDeviceMemoryMonitorFunction(
          s.device,
          [](void* user, ssize_t bytes, bool) {
            *static_cast<ssize_t*>(user) += bytes;
            return true;
          },
          &held);
      const RTCScene scene = s.api.rtcNewScene(s.device);
      if (compact) s.api.rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
      s.api.rtcAttachGeometry(scene, s.Triangle());
      s.api.rtcCommitScene(scene);
      EXPECT_GT(held, 0);  // what is kept, and the least workspace
      EXPECT_EQ(s.HitGeometry(scene), 0u);
      EXPECT_GT(held, 0);  // the call's workspace, which the device keeps
      const ssize_t with_scene = held;
      s.api.rtcReleaseScene(scene);
      EXPECT_LT(held, with_scene);
    }
    EXPECT_EQ(held, 0);
  }
}

// What a commit reserves is enough for calls of any size.
TEST(DropInScene, IsTracedAlsoIfTheMemoryMonitorRefusesAllMore) {
  Session s(DropIn());
  const RTCScene scene = s.SceneOf(s.Triangle());
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device, [](void*, ssize_t bytes, bool) { return bytes <= 0; }, nullptr);
  std::vector<RTCRayHit> rays(100000);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = RayAt(i % 2 ? 0.2f : 5.0f);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  s.api.rtcIntersect1M(scene, &context, rays.data(), static_cast<unsigned int>(rays.size()),
                       sizeof(RTCRayHit));
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(rays[i].hit.geomID, i % 2 ? 0u : RTC_INVALID_GEOMETRY_ID);
  }
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
}

TEST(DropInScene, IsAsItWasIfTheMemoryMonitorRefuses) {
  Session s(DropIn());
  const RTCScene scene = s.SceneOf(s.Triangle());
  s.api.rtcAttachGeometry(scene, s.Triangle(-1));
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device, [](void*, ssize_t, bool) { return false; }, nullptr);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_OUT_OF_MEMORY);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 1u);
}

TEST(DropInScene, FlagsCountFromTheNextCommitOn) {
  Session s(DropIn());
  const RTCScene scene = s.SceneOf(s.Triangle());
  ssize_t held = 0;
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device,
      [](void* user, ssize_t bytes, bool) {
        *static_cast<ssize_t*>(user) += bytes;
        return true;
      },
      &held);
  s.api.rtcSetSceneFlags(scene, RTC_SCENE_FLAG_COMPACT);
  EXPECT_EQ(held, 0);
  s.api.rtcCommitScene(scene);
  EXPECT_LT(held, 0);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
}

TEST(DropInScene, ProgressMonitorMayCallTheApi) {
  static Session* session;
  static RTCScene scene;
  Session s(DropIn());
  session = &s;
  scene = s.NewScene();
  s.api.rtcAttachGeometry(scene, s.Triangle());
  s.api.rtcSetSceneProgressMonitorFunction(
      scene,
      [](void*, double) {
        RTCBounds bounds;
        session->api.rtcGetSceneBounds(scene, &bounds);
        EXPECT_EQ(session->TakeError(), RTC_ERROR_INVALID_OPERATION);
        return session->api.rtcGetGeometryThreadSafe(scene, 0) != nullptr;
      },
      nullptr);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
}

// The real library asks the geometry while it traces.
TEST(DropInScene, MasksWaitForTheCommit) {
  Session s(DropIn());
  const RTCGeometry geometry = s.Triangle();
  const RTCScene scene = s.SceneOf(geometry);
  s.api.rtcSetGeometryMask(geometry, 0);
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), kMiss);
}

TEST(DropInScene, TakesAnyGeometryId) {
  Session s(DropIn());
  const RTCScene scene = s.NewScene();
  s.api.rtcAttachGeometryByID(scene, s.Triangle(), 0xFFFFFFFE);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), 0xFFFFFFFE);
}

}  // namespace
}  // namespace dacrt::tests
