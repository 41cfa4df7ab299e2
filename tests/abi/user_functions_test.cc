// The rays of user functions: what these see of them, and that they may trace them on, on both
// libraries.
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <thread>
#include <vector>

#include "callbacks.h"
#include "model.h"

namespace dacrt::tests {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

template <class Arguments>
void ExpectOwnLane(const Arguments& args, RTCRayN* rays) {
  unsigned int& count = *static_cast<unsigned int*>(args.geometryUserPtr);
  for (unsigned int lane = 0; lane < args.N; ++lane) {
    if (args.valid[lane] == 0) continue;
    EXPECT_EQ(RTCRayN_id(rays, args.N, lane) % args.N, lane);
    ++count;
  }
}

class UserFunctionRays : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(UserFunctionRays);

// As filter functions do.
TEST_P(UserFunctionRays, SeeRaysOfPacketsInTheirLanes) {
  Session s(GetParam()());
  unsigned int count = 0;
  const RTCGeometry user = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryUserData(user, &count);
  s.api.rtcSetGeometryIntersectFunction(user, [](const RTCIntersectFunctionNArguments* args) {
    ExpectOwnLane(*args, RTCRayHitN_RayN(args->rayhit, args->N));
  });
  s.api.rtcSetGeometryOccludedFunction(
      user, [](const RTCOccludedFunctionNArguments* args) { ExpectOwnLane(*args, args->ray); });
  s.api.rtcCommitGeometry(user);
  const RTCScene scene = s.SceneOf(user);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const std::size_t valid_rays = TraceThirdsOfPackets(s, scene, context);
  EXPECT_EQ(count, valid_rays);
  // In an instance, too.
  const RTCGeometry instance = Instance(s, scene, 0);
  s.api.rtcCommitGeometry(instance);
  count = 0;
  EXPECT_EQ(TraceThirdsOfPackets(s, s.SceneOf(instance), context), valid_rays);
  EXPECT_EQ(count, valid_rays);
}

/// Two walls whose bounds all rays of a test enter before they come to either: so each ray is shown
/// to both, in any order.
struct Walls {
  static constexpr float kDistance[2] = {15, 14};  ///< by geometry
  static constexpr float kU = 0.25f;

  unsigned int seen_behind_another = 0;
};

void BoundWall(const RTCBoundsFunctionArguments* args) {
  *args->bounds_o = {-100, -100, 1, 0, 100, 100, 9, 0};
}

void HitWall(const RTCIntersectFunctionNArguments* args) {
  const unsigned int lanes = args->N;
  RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, lanes);
  RTCHitN* const hits = RTCRayHitN_HitN(args->rayhit, lanes);
  for (unsigned int lane = 0; lane < lanes; ++lane) {
    if (args->valid[lane] == 0) continue;
    float& tfar = RTCRayN_tfar(rays, lanes, lane);
    const unsigned int other = 1 - args->geomID;
    if (tfar == RayAt(0).ray.tfar) {
      EXPECT_EQ(RTCHitN_geomID(hits, lanes, lane), RTC_INVALID_GEOMETRY_ID);
    } else {
      EXPECT_EQ(tfar, Walls::kDistance[other]);
      EXPECT_EQ(RTCHitN_geomID(hits, lanes, lane), other);
      EXPECT_EQ(RTCHitN_u(hits, lanes, lane), Walls::kU);
      ++static_cast<Walls*>(args->geometryUserPtr)->seen_behind_another;
    }
    if (tfar < Walls::kDistance[args->geomID]) continue;
    tfar = Walls::kDistance[args->geomID];
    const RTCHit hit{0, 0, 1, Walls::kU, 0, args->primID, args->geomID, {args->context->instID[0]}};
    rtcCopyHitToHitN(hits, &hit, lanes, lane);
  }
}

/// A user primitive with such bounds.
RTCGeometry WallOf(Session& s, void* user_data, RTCIntersectFunctionN function) {
  const RTCGeometry wall = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryUserPrimitiveCount(wall, 1);
  s.api.rtcSetGeometryUserData(wall, user_data);
  s.api.rtcSetGeometryBoundsFunction(wall, BoundWall, nullptr);
  s.api.rtcSetGeometryIntersectFunction(wall, function);
  s.api.rtcCommitGeometry(wall);
  return wall;
}

TEST_P(UserFunctionRays, SeeTheHitSoFar) {
  Session s(GetParam()(), "threads=1");
  Walls walls;
  const RTCScene scene = s.NewScene();
  for (int i = 0; i < 2; ++i) {
    s.api.rtcAttachGeometry(scene, WallOf(s, &walls, HitWall));
  }
  s.api.rtcCommitScene(scene);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> sideways(-3, 3);
  for (const unsigned int count : {1u, 40u, 5000u}) {
    std::vector<RTCRayHit> rays(count, RayAt(0));
    for (RTCRayHit& record : rays) record.ray.dir_x = sideways(random);
    walls = {};
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    s.api.rtcIntersect1M(scene, &context, rays.data(), count, sizeof(RTCRayHit));
    EXPECT_EQ(walls.seen_behind_another, count);
    for (const RTCRayHit& record : rays) ASSERT_EQ(record.hit.geomID, 1u);
  }
}

/// Expects a ray alone, with the hit of a triangle that crosses the bounds of the wall, and changes
/// nothing but where in the triangle that is.
void MoveHit(const RTCIntersectFunctionNArguments* args) {
  auto& record = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  EXPECT_EQ(args->N, 1u);
  EXPECT_FLOAT_EQ(record.ray.tfar, 17.2f);
  EXPECT_EQ(record.hit.geomID, 0u);
  EXPECT_FLOAT_EQ(record.hit.u, 0.2f);
  record.hit.u = 2;
  ++*static_cast<unsigned int*>(args->geometryUserPtr);
}

TEST_P(UserFunctionRays, MayChangeTheHitOfATriangleWhereItIs) {
  Session s(GetParam()());
  const RTCGeometry triangle = s.UncommittedTriangle(30);
  static_cast<float*>(s.api.rtcGetGeometryBufferData(triangle, RTC_BUFFER_TYPE_VERTEX, 0))[2] = -8;
  s.api.rtcCommitGeometry(triangle);
  unsigned int count = 0;
  const RTCGeometry wall = WallOf(s, &count, MoveHit);
  const RTCScene scene = s.NewScene();
  for (const RTCGeometry geometry : {triangle, wall}) s.api.rtcAttachGeometry(scene, geometry);
  s.api.rtcCommitScene(scene);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  // More than once: a scene is not in its leaves before rays have come.
  constexpr unsigned int kCalls = 10;
  for (unsigned int call = 0; call < kCalls; ++call) {
    RTCRayHit record = RayAt(0.2f);
    s.api.rtcIntersect1(scene, &context, &record);
    EXPECT_EQ(record.hit.geomID, 0u);
    EXPECT_EQ(record.hit.u, 2);
    EXPECT_FLOAT_EQ(record.ray.tfar, 17.2f);
  }
  EXPECT_EQ(count, kCalls);
}

/// The user data of a geometry whose functions trace their rays in another scene, or once more in
/// the same.
struct Tracer {
  const Api& api;
  RTCScene target = nullptr;
};

/// A context that says how deep a call is.
struct NestedContext {
  RTCIntersectContext context;
  int depth = 0;
};

NestedContext Deeper(const RTCIntersectContext* context) {
  NestedContext nested;
  rtcInitIntersectContext(&nested.context);
  nested.depth = reinterpret_cast<const NestedContext*>(context)->depth + 1;
  return nested;
}

void IntersectByTracing(const RTCIntersectFunctionNArguments* args) {
  const auto& tracer = *static_cast<const Tracer*>(args->geometryUserPtr);
  NestedContext nested = Deeper(args->context);
  if (nested.depth > 2) return;
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    RTCRayHit record{};
    record.ray = rtcGetRayFromRayN(RTCRayHitN_RayN(args->rayhit, args->N), args->N, i);
    record.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    tracer.api.rtcIntersect1(tracer.target, &nested.context, &record);
    if (record.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    record.hit.geomID += 100;
    record.hit.instID[0] = args->context->instID[0];
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, i) = record.ray.tfar;
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &record.hit, args->N, i);
  }
}

void OccludeByTracing(const RTCOccludedFunctionNArguments* args) {
  const auto& tracer = *static_cast<const Tracer*>(args->geometryUserPtr);
  NestedContext nested = Deeper(args->context);
  if (nested.depth > 2) return;
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    RTCRay ray = rtcGetRayFromRayN(args->ray, args->N, i);
    tracer.api.rtcOccluded1(tracer.target, &nested.context, &ray);
    if (ray.tfar < 0) RTCRayN_tfar(args->ray, args->N, i) = ray.tfar;
  }
}

RTCGeometry NewTracer(Session& s, Tracer& tracer) {
  const RTCGeometry user = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryUserData(user, &tracer);
  s.api.rtcSetGeometryIntersectFunction(user, IntersectByTracing);
  s.api.rtcSetGeometryOccludedFunction(user, OccludeByTracing);
  s.api.rtcCommitGeometry(user);
  return user;
}

/// Traces the row in `scene` in every form. The distance of rays that hit is 10.
void ExpectSquareIsHit(const Api& api, RTCScene scene, unsigned int geometry) {
  ForEachCall([&](const Form& form, Query query) {
    NestedContext nested;
    rtcInitIntersectContext(&nested.context);
    const auto rays = Trace(api, scene, nested.context, form, query, RowOfRays(form));
    for (int i = 0; i < kRays; ++i) {
      if (!MeetsSquare(i)) {
        EXPECT_TRUE(AreSame(rays[i], RowOfRays(form)[i]));
        continue;
      }
      EXPECT_FLOAT_EQ(rays[i].ray.tfar, query == Query::kClosest ? 10 : -kInfinity);
      EXPECT_EQ(rays[i].hit.geomID, query == Query::kClosest ? geometry : RTC_INVALID_GEOMETRY_ID);
    }
  });
}

TEST_P(UserFunctionRays, MayTraceAnotherScene) {
  Session s(GetParam()());
  Tracer tracer{s.api, s.SceneOf(s.Triangle())};
  ExpectSquareIsHit(s.api, s.SceneOf(NewTracer(s, tracer)), 100);
}

// The triangle is at the same distance as what they find, so either is hit.
TEST_P(UserFunctionRays, MayTraceTheirOwnScene) {
  Session s(GetParam()());
  Tracer tracer{s.api};
  const RTCScene scene = tracer.target = s.NewScene();
  s.api.rtcAttachGeometryByID(scene, NewTracer(s, tracer), 5);
  s.api.rtcAttachGeometryByID(scene, s.Triangle(), 7);
  s.api.rtcCommitScene(scene);
  ForEachCall([&](const Form& form, Query query) {
    NestedContext nested;
    rtcInitIntersectContext(&nested.context);
    const auto rays = Trace(s.api, scene, nested.context, form, query, RowOfRays(form));
    EXPECT_FLOAT_EQ(rays[0].ray.tfar, query == Query::kClosest ? 10 : -kInfinity);
    if (query == Query::kAny) return;
    EXPECT_EQ(rays[0].hit.geomID % 100, 7u);
  });
}

TEST_P(UserFunctionRays, MayTraceFromSeveralThreads) {
  Session s(GetParam()());
  Tracer tracer{s.api, s.SceneOf(s.Triangle())};
  const RTCScene scene = s.SceneOf(NewTracer(s, tracer));
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int repeat = 0; repeat < 5; ++repeat) ExpectSquareIsHit(s.api, scene, 100);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace dacrt::tests
