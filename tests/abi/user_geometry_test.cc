// User geometries: what their functions are called with, and what becomes of their answers, in
// every form of a call, on both libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <random>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "callbacks.h"
#include "model.h"

namespace dacrt::tests {
namespace {

constexpr unsigned int kId = 10;
constexpr unsigned int kInstanceId = 11;
constexpr unsigned int kSquares = 3;

/// A scene of squares at z = 0, 1 and 2, and an instance of the same at z = 5, 6 and 7. The real
/// library's code for AVX-512 hangs or fails in occlusion calls for 16 coherent rays and instances.
class Street {
 public:
  explicit Street(const Api& api, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE)
      : s(api, &api == &RealEmbree() ? "isa=avx2" : nullptr),
        squares{api, kSquares},
        scene(s.NewScene()) {
    const RTCScene inner = s.NewScene();
    for (const RTCScene filtered : {inner, scene}) s.api.rtcSetSceneFlags(filtered, flags);
    geometry = NewSquares(s, squares);
    s.api.rtcAttachGeometryByID(inner, geometry, kId);
    s.api.rtcCommitScene(inner);
    const RTCGeometry instance = Instance(s, inner, 5);
    s.api.rtcCommitGeometry(instance);
    s.api.rtcAttachGeometryByID(scene, geometry, kId);
    s.api.rtcAttachGeometryByID(scene, instance, kInstanceId);
    s.api.rtcCommitScene(scene);
  }

  Outcome Trace(const Form& form, Query query, const Judge& judge = Accept,
                const Judge& context = nullptr) {
    return TraceRow(s, scene, form, query, judge, context);
  }

  Session s;
  Squares squares;
  RTCScene scene;
  RTCGeometry geometry;
};

Outcome SortedVisits(Street& street, const Form& form, Query query) {
  Outcome outcome = street.Trace(form, query);
  std::sort(outcome.visits.begin(), outcome.visits.end());
  return outcome;
}

class UserGeometry : public testing::Test {
 protected:
  Street real{RealEmbree()};
  Street ours{DropIn()};
};

TEST_F(UserGeometry, HitsAreWhatItsFunctionWrites) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = real.Trace(form, query);
    const Outcome actual = ours.Trace(form, query);
    std::vector<RTCRayHit> rays = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) {
      if (!MeetsSquare(i)) continue;
      rays[i].ray.tfar = query == Query::kClosest ? 10 : -std::numeric_limits<float>::infinity();
      if (query == Query::kAny) continue;
      const float ng_z = form.call == Form::Call::kRequiredArrays ? 0 : 1;  // no place for it
      rays[i].hit = {0, 0, ng_z, rays[i].ray.org_x, 0.2f, 0, kId, {RTC_INVALID_GEOMETRY_ID}};
    }
    ExpectSameRays(expected.rays, rays);
    ExpectSameRays(actual.rays, rays);
  });
}

TEST_F(UserGeometry, IsAskedOnceForEachRayThatMeetsItsBounds) {
  real.squares.is_hit = ours.squares.is_hit = false;
  std::vector<Visit> all;
  for (int i = 0; i < kRays; ++i) {
    if (!MeetsSquare(i)) continue;
    for (unsigned int square = 0; square < kSquares; ++square) {
      all.push_back({i, kId, square, kInstanceId});
      all.push_back({i, kId, square, RTC_INVALID_GEOMETRY_ID});
    }
  }
  std::sort(all.begin(), all.end());
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = SortedVisits(real, form, query);
    const Outcome actual = SortedVisits(ours, form, query);
    EXPECT_TRUE(actual.visits == all) << actual.visits.size() << " visits";
    EXPECT_EQ(actual.idle_calls, 0);
    // In occlusion calls for packets the real library asks for rays beside the bounds too.
    EXPECT_TRUE(
        std::includes(expected.visits.begin(), expected.visits.end(), all.begin(), all.end()));
    EXPECT_EQ(std::adjacent_find(expected.visits.begin(), expected.visits.end()),
              expected.visits.end());
  });
}

TEST_F(UserGeometry, IsAskedForAsManyRaysAsTheFormHas) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome outcome = ours.Trace(form, query);
    if (IsStream(form)) {
      EXPECT_FALSE(outcome.user_widths.contains(1));
    } else {
      EXPECT_EQ(outcome.user_widths, std::set{form.lanes});
    }
    // Most rays of the row meet the same squares, so the lanes are filled.
    const unsigned int width = *outcome.user_widths.rbegin();
    EXPECT_GE(*outcome.rays_a_visit.rbegin(), width == 1 ? 1 : width - 2);
  });
}

TEST_F(UserGeometry, AnswersForItselfInStreamsOfOneRay) {
  for (const Form& form : StreamForms()) {
    SCOPED_TRACE(Name(form));
    const Outcome outcome = TraceRow(ours.s, ours.scene, form, Query::kClosest, Accept, nullptr, 1);
    EXPECT_EQ(outcome.rays[0].hit.geomID, kId);
    EXPECT_FALSE(outcome.user_widths.contains(1));
  }
}

/// User functions that show their hits to filter functions.
class FilteredUserGeometry : public UserGeometry {
 protected:
  FilteredUserGeometry() {
    for (Street* const street :
         {&real, &ours, &real_with_context_filter, &ours_with_context_filter}) {
      street->squares.asks_filters = true;
    }
  }

  Street real_with_context_filter{RealEmbree(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION};
  Street ours_with_context_filter{DropIn(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION};
};

TEST_F(FilteredUserGeometry, OffersAllHitsIfTheyAreRejected) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = real.Trace(form, query, Reject);
    const Outcome actual = ours.Trace(form, query, Reject);
    ExpectSameOffers(actual.offers, expected.offers);
    EXPECT_EQ(actual.offers.size(), actual.visits.size());
    const std::vector<RTCRayHit> before = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) EXPECT_TRUE(AreSame(actual.rays[i], before[i])) << "ray " << i;
  });
}

TEST_F(FilteredUserGeometry, IsHitWhereAFilterAccepts) {
  const Judge judge = [](Offer& offer) {
    offer.hit.v = 0.75f;
    offer.t -= 0.25f;
    return offer.ray % 8 != 0 && (TopId(offer.hit) == kInstanceId || offer.ray % 2 == 0) &&
           offer.hit.primID >= 1;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = real.Trace(form, query, judge);
    const Outcome actual = ours.Trace(form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
    const std::vector<RTCRayHit> before = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) {
      EXPECT_EQ(AreSame(actual.rays[i], before[i]), !MeetsSquare(i) || i % 8 == 0) << "ray " << i;
    }
    if (query == Query::kAny) return;
    EXPECT_EQ(actual.rays[2].ray.tfar, 11 - 0.25f);
    EXPECT_EQ(actual.rays[3].ray.tfar, 16 - 0.25f);
  });
}

TEST_F(FilteredUserGeometry, HasAFilterForEachKindOfQuery) {
  for (Street* const street : {&real, &ours}) {
    street->s.api.rtcSetGeometryIntersectFilterFunction(street->geometry, nullptr);
  }
  ForEachCall([&](const Form& form, Query query) {
    for (Street* const street : {&real, &ours}) {
      EXPECT_EQ(street->Trace(form, query, Reject).offers.empty(), query == Query::kClosest);
    }
  });
}

// As in the real library also without the scene's flag, and where the geometry's accepts nothing.
TEST_F(FilteredUserGeometry, AsksTheContextsFilterToo) {
  const Judge is_odd = [](const Offer& offer) { return offer.ray % 2 != 0; };
  const Judge is_second = [](const Offer& offer) { return offer.hit.primID == 1; };
  const std::pair<Street*, Street*> streets[] = {
      {&real, &ours}, {&real_with_context_filter, &ours_with_context_filter}};
  for (const auto& [real_street, our_street] : streets) {
    ForEachCall([&, real_street = real_street, our_street = our_street](const Form& form,
                                                                        Query query) {
      const Outcome expected = real_street->Trace(form, query, is_odd, is_second);
      const Outcome actual = our_street->Trace(form, query, is_odd, is_second);
      ExpectSameRays(actual.rays, expected.rays);
      EXPECT_FALSE(actual.context_offers.empty());
      if (query == Query::kClosest) {
        EXPECT_EQ(actual.rays[0].hit.geomID, RTC_INVALID_GEOMETRY_ID);
        EXPECT_EQ(actual.rays[1].hit.primID, 1u);
      }
    });
  }
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct BoundsCase {
  const char* name;
  RTCBounds bounds;
};

/// Bounds for a primitive that is hit at z = 0 wherever its function is asked.
const BoundsCase kBounds[] = {
    {"flat", {0, 0, 0, 0, 1, 1, 0, 0}},
    {"NaN at the lower end", {0, kNan, 0, 0, 1, 1, 1, 0}},
    {"NaN at the upper end", {0, 0, 0, 0, 1, 1, kNan, 0}},
    {"NaN", {kNan, kNan, kNan, 0, kNan, kNan, kNan, 0}},
    {"inverted in x", {1, 0, 0, 0, 0, 1, 1, 0}},
    {"inverted", {1, 1, 1, 0, 0, 0, 0, 0}},
    {"infinite", {-kInfinity, -kInfinity, -kInfinity, 0, kInfinity, kInfinity, kInfinity, 0}},
    {"infinite on one side", {0, 0, 0, 0, 1, 1, kInfinity, 0}},
    {"as far as it goes", {-1.8e18f, -1.8e18f, -1.8e18f, 0, 1.8e18f, 1.8e18f, 1.8e18f, 0}},
    {"too far", {-1.9e18f, 0, 0, 0, 1, 1, 1, 0}},
};

void BoundByUserData(const RTCBoundsFunctionArguments* args) {
  *args->bounds_o = *static_cast<const RTCBounds*>(args->geometryUserPtr);
}

/// A scene of a primitive with these bounds at z = 0 and a triangle behind it.
RTCScene SceneWithBounds(Session& s, const RTCBounds& bounds) {
  const RTCGeometry user = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
  s.api.rtcSetGeometryUserData(user, const_cast<RTCBounds*>(&bounds));
  s.api.rtcSetGeometryBoundsFunction(user, BoundByUserData, nullptr);
  s.api.rtcCommitGeometry(user);
  const RTCScene scene = s.NewScene();
  s.api.rtcAttachGeometry(scene, user);
  s.api.rtcAttachGeometry(scene, s.Triangle(5));
  s.api.rtcCommitScene(scene);
  return scene;
}

TEST(UserBounds, ThatAreNoneLeaveThePrimitiveOut) {
  for (const auto& [name, bounds] : kBounds) {
    SCOPED_TRACE(name);
    RTCBounds scene_bounds[2];
    unsigned int hit[2];
    for (const Api* const api : {&RealEmbree(), &DropIn()}) {
      const bool is_ours = api == &DropIn();
      Session s(*api);
      const RTCScene scene = SceneWithBounds(s, bounds);
      s.api.rtcGetSceneBounds(scene, &scene_bounds[is_ours]);
      hit[is_ours] = s.HitGeometry(scene);
      EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
    }
    EXPECT_EQ(hit[1], hit[0]);
    EXPECT_EQ(std::memcmp(&scene_bounds[1], &scene_bounds[0], sizeof(RTCBounds)), 0);
  }
}

/// What a bounds function was called with.
struct BoundsLog {
  std::vector<std::pair<unsigned int, unsigned int>> calls;  ///< primitive and time step
  std::mutex mutex;
};

void LogBounds(const RTCBoundsFunctionArguments* args) {
  auto& log = *static_cast<BoundsLog*>(args->geometryUserPtr);
  const std::lock_guard lock(log.mutex);
  log.calls.emplace_back(args->primID, args->timeStep);
  *args->bounds_o = {0, 0, 0, 0, 1, 1, 1, 0};
}

// As in the real library, the function's own pointer is not handed over.
TEST(UserBounds, AreAskedForWithTheGeometrysUserData) {
  for (const unsigned int steps : {1u, 3u}) {
    std::set<std::pair<unsigned int, unsigned int>> asked[2];
    for (const Api* const api : {&RealEmbree(), &DropIn()}) {
      Session s(*api);
      BoundsLog log;
      const RTCGeometry user = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
      s.api.rtcSetGeometryUserPrimitiveCount(user, 4);
      s.api.rtcSetGeometryTimeStepCount(user, steps);
      s.api.rtcSetGeometryUserData(user, &log);
      s.api.rtcSetGeometryBoundsFunction(user, LogBounds, &s);
      s.api.rtcCommitGeometry(user);
      EXPECT_EQ(s.HitGeometry(s.SceneOf(user)), 0u);
      asked[api == &DropIn()].insert(log.calls.begin(), log.calls.end());
    }
    EXPECT_EQ(asked[1], asked[0]);
    EXPECT_EQ(asked[1].size(), 4 * steps);
  }
}

class UserFunctions : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(UserFunctions);

TEST_P(UserFunctions, AndUserDataCountWithoutACommit) {
  Street street(GetParam()());
  const Api& api = street.s.api;
  Squares others = street.squares;
  others.is_hit = false;
  api.rtcSetGeometryUserData(street.geometry, &others);
  EXPECT_EQ(street.Trace({}, Query::kClosest).rays[0].hit.geomID, RTC_INVALID_GEOMETRY_ID);
  api.rtcSetGeometryUserData(street.geometry, &street.squares);
  EXPECT_EQ(street.Trace({}, Query::kClosest).rays[0].hit.geomID, kId);
  api.rtcSetGeometryIntersectFunction(street.geometry, [](const auto*) {});
  api.rtcSetGeometryOccludedFunction(street.geometry, [](const auto*) {});
  for (const Query query : {Query::kClosest, Query::kAny}) {
    EXPECT_TRUE(AreSame(street.Trace({}, query).rays[0], RowOfRays()[0]));
  }
}

// The real library calls the null pointer.
TEST(DropInUserFunctions, MayBeMissing) {
  Street street(DropIn());
  street.s.api.rtcSetGeometryIntersectFunction(street.geometry, nullptr);
  street.s.api.rtcSetGeometryOccludedFunction(street.geometry, nullptr);
  ForEachCall([&](const Form& form, Query query) {
    EXPECT_TRUE(AreSame(street.Trace(form, query).rays[0], RowOfRays(form)[0]));
  });
}

template <class Arguments>
void ExpectOwnLane(const Arguments& args, RTCRayN* rays) {
  unsigned int& count = *static_cast<unsigned int*>(args.geometryUserPtr);
  for (unsigned int lane = 0; lane < args.N; ++lane) {
    if (args.valid[lane] == 0) continue;
    EXPECT_EQ(RTCRayN_id(rays, args.N, lane) % args.N, lane);
    ++count;
  }
}

// As filter functions do.
TEST_P(UserFunctions, SeeRaysOfPacketsInTheirLanes) {
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
  const std::size_t valid_rays = TraceThirdsOfPackets(s.api, scene, context);
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

TEST_P(UserFunctions, SeeTheHitSoFar) {
  Session s(GetParam()(), "threads=1");
  Walls walls;
  const RTCScene scene = s.NewScene();
  for (int i = 0; i < 2; ++i) {
    const RTCGeometry wall = UncommittedModel(s, RTC_GEOMETRY_TYPE_USER);
    s.api.rtcSetGeometryUserPrimitiveCount(wall, 1);
    s.api.rtcSetGeometryUserData(wall, &walls);
    s.api.rtcSetGeometryBoundsFunction(wall, BoundWall, nullptr);
    s.api.rtcSetGeometryIntersectFunction(wall, HitWall);
    s.api.rtcCommitGeometry(wall);
    s.api.rtcAttachGeometry(scene, wall);
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

TEST_P(UserFunctions, MayTraceAnotherScene) {
  Session s(GetParam()());
  Tracer tracer{s.api, s.SceneOf(s.Triangle())};
  ExpectSquareIsHit(s.api, s.SceneOf(NewTracer(s, tracer)), 100);
}

// The triangle is at the same distance as what they find, so either is hit.
TEST_P(UserFunctions, MayTraceTheirOwnScene) {
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

TEST_P(UserFunctions, MayTraceFromSeveralThreads) {
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
