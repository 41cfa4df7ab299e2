// Geometries that are attached to a scene of many, one after the other.
#include <gtest/gtest.h>

#include <sys/types.h>

#include <map>

#include "model.h"

namespace dacrt::tests {
namespace {

/// A wall of triangles at z = 50, enough that a drop-in keeps what it has found out about them.
RTCGeometry Wall(Session& s) {
  constexpr unsigned int kSide = 40;
  const RTCGeometry wall = s.NewGeometry();
  auto* const vertices = static_cast<float*>(
      s.api.rtcSetNewGeometryBuffer(wall, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    3 * sizeof(float), (kSide + 1) * (kSide + 1)));
  auto* triangle = static_cast<unsigned int*>(
      s.api.rtcSetNewGeometryBuffer(wall, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(unsigned int), 2 * kSide * kSide));
  for (unsigned int y = 0; y <= kSide; ++y) {
    for (unsigned int x = 0; x <= kSide; ++x) {
      float* const v = vertices + 3 * (y * (kSide + 1) + x);
      v[0] = static_cast<float>(x) * 0.125f - 1, v[1] = static_cast<float>(y) * 0.125f - 1,
      v[2] = 50;
    }
  }
  for (unsigned int y = 0; y < kSide; ++y) {
    for (unsigned int x = 0; x < kSide; ++x) {
      const unsigned int a = y * (kSide + 1) + x, b = a + kSide + 1;
      for (const unsigned int corner : {a, a + 1, b, b + 1, b, a + 1}) *triangle++ = corner;
    }
  }
  s.api.rtcCommitGeometry(wall);
  return wall;
}

class Attach : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Attach);

TEST_P(Attach, GeometriesComeOneAfterTheOtherAndGo) {
  Session s(GetParam()());
  const RTCScene scene = s.SceneOf(Wall(s));
  EXPECT_EQ(s.Distance(scene), 60);
  for (unsigned int id = 1; id <= 30; ++id) {
    const auto z = static_cast<float>(40 - id);
    EXPECT_EQ(s.api.rtcAttachGeometry(scene, s.Triangle(z)), id);
    s.api.rtcCommitScene(scene);
    ASSERT_EQ(s.Distance(scene), 10 + z);
    RTCBounds bounds;
    s.api.rtcGetSceneBounds(scene, &bounds);
    EXPECT_NEAR(bounds.lower_z, z, 1e-4);
  }
  const auto expect = [&](float distance, const char* when) {
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.Distance(scene), distance) << when;
  };
  s.api.rtcDetachGeometry(scene, 30);
  s.api.rtcDisableGeometry(s.api.rtcGetGeometry(scene, 29));
  expect(22, "two have gone");
  s.api.rtcAttachGeometryByID(scene, s.Triangle(5), 31);
  expect(15, "another one has come");
  s.api.rtcDetachGeometry(scene, 31);
  s.api.rtcEnableGeometry(s.api.rtcGetGeometry(scene, 29));
  expect(21, "one is back");
  s.api.rtcAttachGeometryByID(scene, s.Triangle(3), 30);
  s.api.rtcAttachGeometryByID(scene, s.Triangle(2), 32);
  expect(12, "one in the place of another one, and one behind all");
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

// Few and many, in a row or not, in any order.
TEST_P(Attach, GeometriesAreFoundByTheirIds) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  std::map<unsigned int, RTCGeometry> expected;
  for (const unsigned int id : {70u, 3u, 0u, 5000u, 69u, 71u, 200u, 150u, 4u}) {
    expected[id] = s.Triangle(static_cast<float>(id));
    s.api.rtcAttachGeometryByID(scene, expected[id], id);
  }
  for (int i = 0; i < 300; ++i) {
    const RTCGeometry geometry = s.Triangle(0);
    const unsigned int id = s.api.rtcAttachGeometry(scene, geometry);
    EXPECT_TRUE(expected.emplace(id, geometry).second) << id;
  }
  for (const auto& [id, geometry] : expected) {
    EXPECT_EQ(s.api.rtcGetGeometry(scene, id), geometry) << id;
  }
  for (const unsigned int id : {70u, 5000u, 0u, 150u}) {
    s.api.rtcDetachGeometry(scene, id);
    expected[id] = s.Triangle(1);
    s.api.rtcAttachGeometryByID(scene, expected[id], id);
    EXPECT_EQ(s.api.rtcGetGeometry(scene, id), expected[id]) << id;
  }
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

// A scene that instances show, and the scene that shows it.
TEST_P(Attach, WhatInstancesShowGrows) {
  Session s(GetParam()());
  const RTCScene inner = s.SceneOf(Wall(s));
  const RTCGeometry instance = Instance(s, inner, 0);
  s.api.rtcCommitGeometry(instance);
  const RTCScene scene = s.SceneOf(instance);
  EXPECT_EQ(s.Distance(scene), 60);
  for (int i = 0; i < 5; ++i) {
    const auto z = static_cast<float>(20 - i);
    s.api.rtcAttachGeometry(inner, s.Triangle(z));
    s.api.rtcCommitScene(inner);
    EXPECT_EQ(s.Distance(inner), 10 + z);
    s.api.rtcCommitGeometry(instance);
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.Distance(scene), 10 + z);
  }
}

bool Add(void* bytes, ssize_t change, bool) {
  if (change > 0) *static_cast<ssize_t*>(bytes) += change;
  return true;
}

// The first time that something comes the partition gets a place with more room.
TEST(AttachToTheDropIn, TakesMemoryForWhatComesAndNotForTheScene) {
  Session s(DropIn());
  const RTCScene scene = s.SceneOf(Wall(s));
  EXPECT_EQ(s.Distance(scene), 60);
  ssize_t bytes = 0;
  for (int i = 0; i < 20; ++i) {
    s.api.rtcAttachGeometry(scene, s.Triangle(10));
    s.api.rtcSetDeviceMemoryMonitorFunction(s.device, &Add, &bytes);
    bytes = 0;
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.Distance(scene), 20);
    s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
    if (i > 0) {
      EXPECT_LT(bytes, 1000) << i;
    }
  }
}

}  // namespace
}  // namespace dacrt::tests
