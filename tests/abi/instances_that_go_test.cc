// Instances that are disabled, detached, and come back.
#include <gtest/gtest.h>

#include <sys/types.h>

#include <functional>

#include "model.h"

namespace dacrt::tests {
namespace {

RTCGeometry CommittedInstance(Session& s, RTCScene inner, float z) {
  const RTCGeometry instance = Instance(s, inner, z);
  s.api.rtcCommitGeometry(instance);
  return instance;
}

/// Commits a scene, and expects how far a ray goes, where the scene begins, and no error.
void ExpectAtCommit(Session& s, RTCScene scene, float distance, float lower, const char* when) {
  s.ExpectAtCommit(scene, distance, when);
  RTCBounds bounds;
  s.api.rtcGetSceneBounds(scene, &bounds);
  EXPECT_NEAR(bounds.lower_z, lower, 1e-4) << when;
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE) << when;
}

class InstancesThatGo : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(InstancesThatGo);

TEST_P(InstancesThatGo, AreNotThereAndComeBackAsTheyAreByThen) {
  Session s(GetParam()());
  const RTCScene inner = s.SceneOf(s.Triangle());
  const RTCGeometry near = CommittedInstance(s, inner, -1), middle = CommittedInstance(s, inner, 0),
                    far = CommittedInstance(s, inner, 3);
  const RTCScene scene = s.SceneOf(near);
  s.api.rtcAttachGeometry(scene, middle);
  s.api.rtcAttachGeometry(scene, far);
  s.api.rtcAttachGeometry(scene, s.Triangle(5));
  const auto expect = [&](float distance, float lower, const char* when) {
    ExpectAtCommit(s, scene, distance, lower, when);
  };
  expect(9, -1, "all");
  s.api.rtcDisableGeometry(near);
  expect(10, 0, "without the near one");
  s.api.rtcDisableGeometry(middle);
  expect(13, 3, "without two");
  const float matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 2};
  s.api.rtcSetGeometryTransform(near, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
  s.api.rtcCommitGeometry(near);
  expect(13, 3, "one moves while it is away");
  s.api.rtcEnableGeometry(near);
  expect(12, 2, "it comes back");
  s.api.rtcEnableGeometry(middle);
  expect(10, 0, "all again");
  s.api.rtcDisableGeometry(near);
  s.api.rtcDisableGeometry(middle);
  s.api.rtcDisableGeometry(far);
  expect(15, 5, "none");
  s.api.rtcEnableGeometry(far);
  s.api.rtcDetachGeometry(scene, 1);
  expect(13, 3, "the middle one is detached");
  s.api.rtcAttachGeometryByID(scene, s.Triangle(2), 1);
  expect(12, 2, "something else has its ID");
  s.api.rtcDisableGeometry(far);
  s.api.rtcDetachGeometry(scene, 2);
  const RTCGeometry other = s.Triangle(1);
  s.api.rtcDisableGeometry(other);
  s.api.rtcAttachGeometryByID(scene, other, 2);
  expect(12, 2, "something else that is disabled has its ID");
}

TEST_P(InstancesThatGo, AreDetachedAndOthersComeInTheirPlace) {
  Session s(GetParam()());
  const RTCScene inner = s.SceneOf(s.Triangle());
  const RTCGeometry near = CommittedInstance(s, inner, -1), far = CommittedInstance(s, inner, 3);
  const RTCScene scene = s.SceneOf(near);
  s.api.rtcAttachGeometry(scene, far);
  s.api.rtcAttachGeometry(scene, s.Triangle(5));
  const auto expect = [&](float distance, float lower, const char* when) {
    ExpectAtCommit(s, scene, distance, lower, when);
  };
  expect(9, -1, "all");
  for (int i = 0; i < 3; ++i) {
    s.api.rtcDetachGeometry(scene, 0);
    expect(13, 3, "the near one is detached");
    s.api.rtcAttachGeometryByID(scene, near, 0);
    expect(9, -1, "it is attached again");
  }
  const RTCScene other = s.SceneOf(s.Triangle(1));
  s.api.rtcDetachGeometry(scene, 0);
  const RTCGeometry another = CommittedInstance(s, other, 0);
  s.api.rtcAttachGeometryByID(scene, another, 0);
  expect(11, 1, "another one comes in its place");
  s.api.rtcAttachGeometry(other, s.Triangle(-1));
  s.api.rtcCommitScene(other);
  s.api.rtcCommitGeometry(another);
  expect(9, -1, "what it shows has grown");
  s.api.rtcDetachGeometry(scene, 0);
  s.api.rtcDetachGeometry(scene, 1);
  expect(15, 5, "both are detached");
  s.api.rtcSetGeometryMask(near, 2);
  s.api.rtcCommitGeometry(near);
  s.api.rtcAttachGeometryByID(scene, near, 0);
  const RTCGeometry moving = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE));
  s.api.rtcSetGeometryInstancedScene(moving, inner);
  s.api.rtcSetGeometryTimeStepCount(moving, 2);
  s.api.rtcCommitGeometry(moving);
  s.api.rtcAttachGeometryByID(scene, moving, 1);
  expect(9, -1, "one with a mask, and one that moves");
  for (const unsigned int mask : {1u, 2u}) {
    RTCRayHit ray = RayAt(0.2f, mask);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    s.api.rtcIntersect1(scene, &context, &ray);
    EXPECT_EQ(ray.hit.instID[0], mask == 1 ? 1u : 0u);
  }
}

TEST_P(InstancesThatGo, ShowTheirSceneAsItIsWhenTheyComeBack) {
  Session s(GetParam()());
  const RTCScene inner = s.SceneOf(s.Triangle(3));
  const RTCGeometry instance = CommittedInstance(s, inner, 0);
  const RTCScene scene = s.SceneOf(instance);
  s.api.rtcAttachGeometry(scene, s.Triangle(5));
  s.api.rtcDisableGeometry(instance);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 15);
  s.api.rtcAttachGeometry(inner, s.Triangle(1));
  s.api.rtcCommitScene(inner);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 15);
  s.api.rtcEnableGeometry(instance);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 11);
}

/// Bytes that a drop-in holds at last, of a scene of a triangle and an instance to which `happens`.
ssize_t Held(
    const std::function<void(Session&, RTCScene scene, RTCScene inner, RTCGeometry)>& happens) {
  ssize_t held = 0;
  Session s(DropIn());
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device,
      [](void* user, ssize_t bytes, bool) {
        *static_cast<ssize_t*>(user) += bytes;
        return true;
      },
      &held);
  const RTCScene inner = s.api.rtcNewScene(s.device);
  s.api.rtcAttachGeometry(inner, s.Triangle());
  s.api.rtcCommitScene(inner);
  const RTCGeometry instance = s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE);
  s.api.rtcSetGeometryInstancedScene(instance, inner);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(s.Triangle(5));
  s.api.rtcAttachGeometry(scene, instance);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 10);
  happens(s, scene, inner, instance);
  s.api.rtcReleaseGeometry(instance);
  s.api.rtcReleaseScene(inner);
  EXPECT_EQ(s.Distance(scene), 15);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  const ssize_t at_last = held;
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
  return at_last;
}

void DisableAndCommit(Session& s, RTCScene scene, RTCScene, RTCGeometry instance) {
  s.api.rtcDisableGeometry(instance);
  s.api.rtcCommitScene(scene);
}

void DetachAndCommit(Session& s, RTCScene scene, RTCScene, RTCGeometry) {
  s.api.rtcDetachGeometry(scene, 1);
  s.api.rtcCommitScene(scene);
}

void CommitInner(Session& s, RTCScene, RTCScene inner, RTCGeometry) {
  s.api.rtcAttachGeometry(inner, s.Triangle(1));
  s.api.rtcCommitScene(inner);
}

// What Embree would have released is not kept for an instance that may come back.
TEST(DropInInstancesThatGo, KeepNothingOnceTheyAreDetached) {
  const ssize_t detached = Held(DetachAndCommit);
  EXPECT_EQ(Held([](Session& s, RTCScene scene, RTCScene inner, RTCGeometry instance) {
              DisableAndCommit(s, scene, inner, instance);
              DetachAndCommit(s, scene, inner, instance);
            }),
            detached);
  EXPECT_GT(Held(DisableAndCommit), detached);
}

TEST(DropInInstancesThatGo, KeepNoSceneThatIsNotTheirsAnyMore) {
  const auto held = [](bool all) {
    return Held([=](Session& s, RTCScene scene, RTCScene inner, RTCGeometry instance) {
      if (all) DisableAndCommit(s, scene, inner, instance);
      CommitInner(s, scene, inner, instance);
      if (!all) DisableAndCommit(s, scene, inner, instance);
    });
  };
  EXPECT_EQ(held(true), held(false));
}

ssize_t held_now;

// What they show goes with them at the commit, or when the program releases it later.
TEST(DropInInstancesThatGo, KeepNoScene) {
  for (const bool is_released_before : {false, true}) {
    Session s(DropIn());
    s.api.rtcSetDeviceMemoryMonitorFunction(
        s.device, [](void*, ssize_t bytes, bool) { return held_now += bytes, true; }, nullptr);
    held_now = 0;
    const RTCScene inner = s.api.rtcNewScene(s.device);
    s.api.rtcAttachGeometry(inner, s.Triangle());
    s.api.rtcCommitScene(inner);
    const ssize_t of_inner = held_now;
    ASSERT_GT(of_inner, 0);
    const RTCGeometry instance = s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE);
    s.api.rtcSetGeometryInstancedScene(instance, inner);
    s.api.rtcCommitGeometry(instance);
    const RTCScene scene = s.SceneOf(s.Triangle(5));
    s.api.rtcAttachGeometry(scene, instance);
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.Distance(scene), 10);
    EXPECT_EQ(s.Distance(inner), 10);
    const ssize_t of_all = held_now;
    s.api.rtcDetachGeometry(scene, 1);
    const auto release = [&] {
      s.api.rtcReleaseGeometry(instance);
      s.api.rtcReleaseScene(inner);
    };
    if (is_released_before) release();
    EXPECT_EQ(held_now, of_all);
    s.api.rtcCommitScene(scene);
    if (!is_released_before) release();
    EXPECT_LT(held_now, of_all);
    EXPECT_EQ(s.Distance(scene), 15);
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
    s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
  }
}

TEST(DropInInstancesThatGo, AskForNoMemory) {
  Session s(DropIn());
  const RTCScene inner = s.SceneOf(s.Triangle()), other = s.SceneOf(s.Triangle(1));
  const RTCGeometry instance = CommittedInstance(s, inner, 0);
  const RTCScene scene = s.SceneOf(instance);
  s.api.rtcAttachGeometry(scene, s.Triangle(5));
  s.api.rtcCommitScene(scene);
  const RTCGeometry another = CommittedInstance(s, other, 0);
  EXPECT_EQ(s.Distance(scene), 10);
  s.RefuseMemory();
  const auto expect = [&](float distance, const char* when) {
    s.ExpectAtCommit(scene, distance, when);
  };
  s.api.rtcDisableGeometry(instance);
  expect(15, "disabled");
  s.api.rtcEnableGeometry(instance);
  expect(10, "enabled");
  s.api.rtcDetachGeometry(scene, 0);
  expect(15, "detached");
  s.api.rtcAttachGeometryByID(scene, instance, 0);
  expect(10, "attached again");
  s.api.rtcDetachGeometry(scene, 0);
  s.api.rtcAttachGeometryByID(scene, another, 0);
  expect(11, "another one comes in its place");
  s.api.rtcSetGeometryInstancedScene(another, inner);
  s.api.rtcCommitGeometry(another);
  expect(10, "which shows another scene");
  s.GrantMemory();
}

TEST(DropInInstancesThatGo, LeaveASceneOfWhichThereMayBeInstances) {
  Session s(DropIn());
  const RTCGeometry instance = CommittedInstance(s, s.SceneOf(s.Triangle()), 0);
  const RTCScene middle = s.SceneOf(instance);
  s.api.rtcAttachGeometry(middle, s.Triangle(2));
  s.api.rtcCommitScene(middle);
  s.api.rtcDisableGeometry(instance);
  s.api.rtcCommitScene(middle);
  const RTCScene outer = s.SceneOf(CommittedInstance(s, middle, 1));
  EXPECT_EQ(s.Distance(outer), 13);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

}  // namespace
}  // namespace dacrt::tests
