// What a query call reads and writes, in every form of it, on both libraries. Whether hits are
// right is the conformance tests' matter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "forms.h"
#include "session.h"

namespace dacrt::tests {
namespace {

const Form kForms[] = {
    {Form::Call::kRecord},
    {Form::Call::kPacket, false, 4},
    {Form::Call::kPacket, false, 8},
    {Form::Call::kPacket, false, 16},
    {Form::Call::kRecords},
    {Form::Call::kRecordPointers},
    {Form::Call::kPackets, false, 4},
    {Form::Call::kArrays},
};

class QueryForm : public testing::TestWithParam<std::tuple<const Api& (*)(), Form>> {
 protected:
  QueryForm() : s(std::get<0>(GetParam())()), form(std::get<1>(GetParam())) {
    rtcInitIntersectContext(&context);
    scene = s.NewScene();
    s.api.rtcAttachGeometryByID(scene, s.Triangle(), 3);
    s.api.rtcCommitScene(scene);
  }

  std::vector<RTCRayHit> TraceRow(RTCScene traced, Query query) {
    return Trace(s.api, traced, context, form, query, RowOfRays());
  }

  /// Neither query changes anything.
  void ExpectTouchesNoRay(RTCScene traced) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      EXPECT_TRUE(AreEqual(TraceRow(traced, query), RowOfRays()));
    }
  }

  static bool AreEqual(const std::vector<RTCRayHit>& a, const std::vector<RTCRayHit>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
  }

  Session s;
  const Form form;
  RTCIntersectContext context;
  RTCScene scene;
};

INSTANTIATE_TEST_SUITE_P(
    , QueryForm, testing::Combine(testing::Values(&RealEmbree, &DropIn), testing::ValuesIn(kForms)),
    [](const auto& info) {
      return std::get<0>(info.param)().name + "_" + Name(std::get<1>(info.param));
    });

TEST_P(QueryForm, ClosestHitWritesHitsAndNothingElse) {
  context.instID[0] = 5;
  const std::vector<RTCRayHit> traced = TraceRow(scene, Query::kClosest);
  std::vector<RTCRayHit> expected = RowOfRays();
  for (int i = 0; i < kRays; ++i) {
    if (!MeetsSquare(i)) continue;
    const RTCRayHit& actual = traced[i];
    EXPECT_FLOAT_EQ(actual.hit.u, expected[i].ray.org_x);
    EXPECT_FLOAT_EQ(actual.hit.v, 0.2f);
    EXPECT_FLOAT_EQ(actual.ray.tfar, 10);
    expected[i].ray.tfar = actual.ray.tfar;
    // -0 where the real library has it
    expected[i].hit = {std::copysign(0.0f, actual.hit.Ng_x),
                       std::copysign(0.0f, actual.hit.Ng_y),
                       1,
                       actual.hit.u,
                       actual.hit.v,
                       0,
                       3,
                       {5}};
  }
  EXPECT_TRUE(AreEqual(traced, expected));
}

TEST_P(QueryForm, AnyHitWritesTfarAndNothingElse) {
  std::vector<RTCRayHit> expected = RowOfRays();
  for (int i = 0; i < kRays; ++i) {
    if (MeetsSquare(i)) expected[i].ray.tfar = -INFINITY;
  }
  EXPECT_TRUE(AreEqual(TraceRow(scene, Query::kAny), expected));
}

TEST_P(QueryForm, UncommittedSceneTouchesNoRay) {
  ExpectTouchesNoRay(s.NewScene());
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_OPERATION);
}

TEST_P(QueryForm, EmptySceneTouchesNoRay) {
  const RTCScene empty = s.NewScene();
  s.api.rtcCommitScene(empty);
  ExpectTouchesNoRay(empty);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

class Packets : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Packets);

/// Sends rays that all hit, of which lane 1 is not valid and lane 2 has a flag that is neither 0
/// nor -1, and expects the distance `hit` of those that take part.
template <int kLanes, class Packet, class Function>
void ExpectDistances(const Session& s, Function Api::*function, RTCScene scene, float hit) {
  alignas(64) int valid[kLanes];
  std::fill_n(valid, kLanes, -1);
  valid[1] = 0;
  valid[2] = 1;
  alignas(64) Packet packet{};
  const RTCRay ray = RayAt(0.2f).ray;
  auto* const rays = reinterpret_cast<RTCRayN*>(&packet);  // which come first where there are hits
  for (int lane = 0; lane < kLanes; ++lane) SetLane(rays, kLanes, lane, ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  (s.api.*function)(valid, scene, &context, &packet);
  for (int lane = 0; lane < kLanes; ++lane) {
    const bool takes_part = lane != 1 && lane != 2;
    EXPECT_EQ(WholeDistance(s.api, RTCRayN_tfar(rays, kLanes, lane)), takes_part ? hit : ray.tfar)
        << "lane " << lane;
  }
}

TEST_P(Packets, OnlyLanesWithMinusOneTakePart) {
  Session s(GetParam()());
  const RTCScene scene = s.SceneOf(s.Triangle());
  ExpectDistances<4, RTCRayHit4>(s, &Api::rtcIntersect4, scene, 10);
  ExpectDistances<8, RTCRayHit8>(s, &Api::rtcIntersect8, scene, 10);
  ExpectDistances<4, RTCRay4>(s, &Api::rtcOccluded4, scene, -INFINITY);
  ExpectDistances<8, RTCRay8>(s, &Api::rtcOccluded8, scene, -INFINITY);
  if (!HasPacketsOf16(s)) return;
  ExpectDistances<16, RTCRayHit16>(s, &Api::rtcIntersect16, scene, 10);
  ExpectDistances<16, RTCRay16>(s, &Api::rtcOccluded16, scene, -INFINITY);
}

class Pointers : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Pointers);

// Real programs pass null for what they have no use for.
TEST_P(Pointers, MayBeNullForOptionalComponents) {
  Session s(GetParam()());
  const RTCScene scene = s.SceneOf(s.Triangle());
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  float org_x[2] = {0.2f, 5}, org_y[2] = {0.2f, 0.2f}, org_z[2] = {-10, -10};
  float dir_xy[2] = {0, 0}, dir_z[2] = {1, 1}, tfar[2] = {100, 100};
  float u[2] = {7, 7}, v[2] = {7, 7};
  unsigned int prim_id[2] = {7, 7}, geom_id[2] = {7, 7};
  RTCRayHitNp rays{};
  rays.ray.org_x = org_x;
  rays.ray.org_y = org_y;
  rays.ray.org_z = org_z;
  rays.ray.dir_x = rays.ray.dir_y = dir_xy;
  rays.ray.dir_z = dir_z;
  rays.ray.tfar = tfar;
  rays.hit.u = u;
  rays.hit.v = v;
  rays.hit.primID = prim_id;
  rays.hit.geomID = geom_id;
  s.api.rtcIntersectNp(scene, &context, &rays, 2);
  EXPECT_NEAR(tfar[0], 10, 1e-4);
  EXPECT_NEAR(u[0], 0.2f, 1e-5);
  EXPECT_EQ(geom_id[0], 0u);
  EXPECT_EQ(prim_id[0], 0u);
  EXPECT_EQ(tfar[1], 100);
  EXPECT_EQ(geom_id[1], 7u);

  tfar[0] = 100;
  s.api.rtcOccludedNp(scene, &context, &rays.ray, 2);
  EXPECT_EQ(tfar[0], -INFINITY);
  EXPECT_EQ(tfar[1], 100);
}

}  // namespace
}  // namespace dacrt::tests
