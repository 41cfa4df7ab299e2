// User geometries: what their functions are called with, and what becomes of their answers, in
// every form of a call, on both libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <set>
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

}  // namespace
}  // namespace dacrt::tests
