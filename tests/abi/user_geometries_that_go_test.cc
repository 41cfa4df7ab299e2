// User geometries that are disabled, detached, and come back, beside a mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "model.h"

namespace dacrt::tests {
namespace {

/// How much lower bounds are at the second time step.
constexpr float kSunk = 0.25f;

/// What its functions know of a user geometry: a square at z.
struct Floor {
  float z = 0;
  int asked = 0;  ///< for bounds
  int called = 0;
  RTCScene scene = nullptr;  ///< to which the bounds function attaches what follows
  RTCGeometry other = nullptr;
  const Api* api = nullptr;
};

void Bound(const RTCBoundsFunctionArguments* args) {
  auto& floor = *static_cast<Floor*>(args->geometryUserPtr);
  ++floor.asked;
  const float lower = args->timeStep == 1 ? floor.z - kSunk : floor.z;
  *args->bounds_o = {0, 0, lower, 0, 1, 1, floor.z, 0};
  if (floor.scene) floor.api->rtcAttachGeometry(floor.scene, floor.other);
}

void Intersect(const RTCIntersectFunctionNArguments* args) {
  auto& floor = *static_cast<Floor*>(args->geometryUserPtr);
  ++floor.called;
  RTCRayN* const ray = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* const hit = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned int i = 0; i < args->N; ++i) {
    const float t = floor.z - RTCRayN_org_z(ray, args->N, i);
    if (!args->valid[i] || t >= RTCRayN_tfar(ray, args->N, i)) continue;
    RTCRayN_tfar(ray, args->N, i) = t;
    RTCHitN_geomID(hit, args->N, i) = args->geomID;
    RTCHitN_primID(hit, args->N, i) = args->primID;
  }
}

RTCGeometry FloorAt(Session& s, Floor& floor, unsigned int steps = 1) {
  const RTCGeometry user = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_USER));
  s.api.rtcSetGeometryUserPrimitiveCount(user, 1);
  s.api.rtcSetGeometryTimeStepCount(user, steps);
  s.api.rtcSetGeometryUserData(user, &floor);
  s.api.rtcSetGeometryBoundsFunction(user, Bound, nullptr);
  s.api.rtcSetGeometryIntersectFunction(user, Intersect);
  s.api.rtcCommitGeometry(user);
  return user;
}

class UserGeometriesThatGo : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(UserGeometriesThatGo);

TEST_P(UserGeometriesThatGo, AreNotThereAndComeBackAsTheyAreByThen) {
  for (const unsigned int steps : {1u, 2u}) {
    Session s(GetParam()());
    Floor near{.z = 1}, far{.z = 3};
    const RTCGeometry near_user = FloorAt(s, near, steps), far_user = FloorAt(s, far, steps);
    const RTCScene scene = s.SceneOf(near_user);
    s.api.rtcAttachGeometry(scene, far_user);
    s.api.rtcAttachGeometry(scene, s.Triangle(5));
    unsigned int primitives = 1;
    const auto expect = [&](float distance, bool asks_near, bool asks_far, const char* when) {
      near.asked = far.asked = near.called = far.called = 0;
      s.api.rtcCommitScene(scene);
      EXPECT_EQ(near.asked > 0, asks_near) << when;
      EXPECT_EQ(far.asked > 0, asks_far) << when;
      if (&s.api == &DropIn()) {
        EXPECT_LE(std::max(near.asked, far.asked), static_cast<int>(steps * primitives)) << when;
      }
      EXPECT_EQ(s.Distance(scene), distance) << when;
      EXPECT_EQ(near.called > 0, asks_near) << when;
      RTCBounds bounds;
      s.api.rtcGetSceneBounds(scene, &bounds);
      const float sunk = steps == 2 && (asks_near || asks_far) ? kSunk : 0;
      EXPECT_EQ(bounds.lower_z, distance - 10 - sunk) << when;
      EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE) << when;
    };
    expect(11, true, true, "all");
    EXPECT_EQ(s.HitGeometry(scene), 0u);
    s.api.rtcDisableGeometry(near_user);
    expect(13, false, true, "without the near one");
    s.api.rtcDetachGeometry(scene, 1);
    expect(15, false, false, "without both");
    near.z = 2;
    s.api.rtcEnableGeometry(near_user);
    expect(12, true, false, "it comes back elsewhere");
    far.z = 4;
    s.api.rtcAttachGeometryByID(scene, far_user, 1);
    near.z = 1;
    expect(11, true, true, "all, and are asked where they are");
    s.api.rtcDetachGeometry(scene, 0);
    expect(14, false, true, "the near one is detached");
    Floor other{.z = 0};
    s.api.rtcAttachGeometryByID(scene, FloorAt(s, other, steps), 0);
    expect(10, false, true, "another one has its ID");
    s.api.rtcDetachGeometry(scene, 0);
    s.api.rtcAttachGeometryByID(scene, near_user, 0);
    s.api.rtcSetGeometryMask(far_user, 2);
    s.api.rtcCommitGeometry(far_user);
    expect(11, true, true, "the near one again, and another mask");
    EXPECT_EQ(s.HitGeometry(scene, 2), 0u);
    s.api.rtcSetGeometryMask(near_user, 1);
    s.api.rtcCommitGeometry(near_user);
    expect(11, true, true, "masks");
    EXPECT_EQ(s.HitGeometry(scene, 2), 1u);
    s.api.rtcDetachGeometry(scene, 1);
    s.api.rtcAttachGeometryByID(scene, s.Triangle(2), 1);
    expect(11, true, false, "a triangle has the ID of one");
    EXPECT_EQ(s.HitGeometry(scene, 2), 1u);
    primitives = 2;
    s.api.rtcSetGeometryUserPrimitiveCount(near_user, primitives);
    s.api.rtcCommitGeometry(near_user);
    expect(11, true, false, "another number of primitives, and none is asked twice");
  }
}

// The program may release it at once, with what its functions know.
TEST(DropInUserGeometriesThatGo, AskForNoMemoryAndKeepNothing) {
  Session s(DropIn());
  auto floor = std::make_unique<Floor>(Floor{.z = 1});
  const RTCGeometry user = s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryUserPrimitiveCount(user, 1);
  s.api.rtcSetGeometryUserData(user, floor.get());
  s.api.rtcSetGeometryBoundsFunction(user, Bound, nullptr);
  s.api.rtcSetGeometryIntersectFunction(user, Intersect);
  s.api.rtcCommitGeometry(user);
  const RTCScene scene = s.SceneOf(user);
  s.api.rtcAttachGeometry(scene, s.Triangle(5));
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 11);
  s.RefuseMemory();
  const auto expect = [&](float distance, const char* when) {
    s.ExpectAtCommit(scene, distance, when);
  };
  s.api.rtcDisableGeometry(user);
  expect(15, "disabled");
  s.api.rtcEnableGeometry(user);
  expect(11, "enabled");
  floor->z = 2;
  s.api.rtcCommitGeometry(user);
  expect(12, "moved");
  s.api.rtcDetachGeometry(scene, 0);
  expect(15, "detached");
  s.api.rtcAttachGeometryByID(scene, user, 0);
  expect(12, "attached again");
  s.api.rtcDetachGeometry(scene, 0);
  s.api.rtcReleaseGeometry(user);
  s.api.rtcCommitScene(scene);
  floor.reset();
  expect(15, "released");
  // Towards the corner of all space.
  RTCRayHit ray = RayAt(0.2f);
  ray.ray.org_x = ray.ray.org_y = ray.ray.org_z = 0;
  ray.ray.dir_x = ray.ray.dir_y = ray.ray.dir_z = 1;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  s.api.rtcIntersect1(scene, &context, &ray);
  EXPECT_EQ(ray.hit.geomID, RTC_INVALID_GEOMETRY_ID);
  Floor other{.z = 3};
  s.api.rtcAttachGeometryByID(scene, FloorAt(s, other), 0);
  expect(13, "another one");
  s.GrantMemory();
}

// It is called while the scene may change: other threads attach geometries meanwhile, too.
TEST(DropInUserGeometriesThatGo, MayAttachOthersWhereTheyAreAskedForBounds) {
  Session s(DropIn());
  Floor floor{.z = 3, .other = s.Triangle(1), .api = &s.api};
  const RTCScene scene = s.SceneOf(FloorAt(s, floor));
  const RTCGeometry triangle = s.Triangle(2);
  s.api.rtcAttachGeometry(scene, triangle);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 12);
  s.api.rtcDisableGeometry(triangle);
  floor.scene = scene;
  s.api.rtcCommitScene(scene);
  floor.scene = nullptr;
  EXPECT_EQ(s.Distance(scene), 11);
  s.api.rtcEnableGeometry(triangle);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.Distance(scene), 11);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

}  // namespace
}  // namespace dacrt::tests
