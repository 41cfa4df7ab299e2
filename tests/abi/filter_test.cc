// Filter functions of geometries and of contexts, in every form of a call, on both libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "callbacks.h"
#include "model.h"

namespace dacrt::tests {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The types whose hits the library finds itself. Of an instance, the geometry in it has filters.
constexpr RTCGeometryType kTypes[] = {
    RTC_GEOMETRY_TYPE_TRIANGLE,   RTC_GEOMETRY_TYPE_QUAD,
    RTC_GEOMETRY_TYPE_GRID,       RTC_GEOMETRY_TYPE_SPHERE_POINT,
    RTC_GEOMETRY_TYPE_DISC_POINT, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT,
    RTC_GEOMETRY_TYPE_INSTANCE,
};
constexpr unsigned int kFirstId = 10;
constexpr unsigned int kInstanceId = kFirstId + 6;
constexpr unsigned int kInnerId = 3;

bool IsReal(const Api& api) { return &api == &RealEmbree(); }

/// One geometry of each type, four apart along the rays, all with filter functions. The real
/// library's code for AVX-512 hangs or fails in occlusion calls for 16 coherent rays and instances.
class Tower {
 public:
  explicit Tower(const Api& api, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE,
                 const char* config = nullptr)
      : s(api, IsReal(api) ? "isa=avx2" : config), scene(s.NewScene()), flags_(flags) {
    s.api.rtcSetSceneFlags(scene, flags);
    float z = 0;
    unsigned int id = kFirstId;
    for (const RTCGeometryType& type : kTypes) {
      s.api.rtcAttachGeometryByID(scene, Floor(type, z), id++);
      z += 4;
    }
    s.api.rtcCommitScene(scene);
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  }

  /// Gives the geometries filter functions for `query` and none for the other.
  void SetFilters(Query query) {
    for (const RTCGeometry geometry : filtered_) {
      const bool is_closest = query == Query::kClosest;
      s.api.rtcSetGeometryIntersectFilterFunction(geometry,
                                                  is_closest ? FilterOfGeometry : nullptr);
      s.api.rtcSetGeometryOccludedFilterFunction(geometry, is_closest ? nullptr : FilterOfGeometry);
    }
  }

  RTCScene SceneOfInstance() const { return inner_; }

  Session s;
  RTCScene scene;

 private:
  RTCGeometry Floor(const RTCGeometryType& type, float z) {
    if (type == RTC_GEOMETRY_TYPE_INSTANCE) return InstanceFloor(z);
    const RTCGeometry geometry = s.Own(s.api.rtcNewGeometry(s.device, type));
    SetVertices(s, geometry, type, 0, z, IsPoint(type) ? 1 : 4);
    SetPrimitives(s, geometry, type);
    s.api.rtcSetGeometryIntersectFilterFunction(geometry, FilterOfGeometry);
    s.api.rtcSetGeometryOccludedFilterFunction(geometry, FilterOfGeometry);
    s.api.rtcSetGeometryUserData(geometry, const_cast<RTCGeometryType*>(&type));
    s.api.rtcCommitGeometry(geometry);
    filtered_.push_back(geometry);
    return geometry;
  }

  RTCGeometry InstanceFloor(float z) {
    inner_ = s.NewScene();
    s.api.rtcSetSceneFlags(inner_, flags_);
    s.api.rtcAttachGeometryByID(inner_, Floor(kTypes[0], 0), kInnerId);
    s.api.rtcCommitScene(inner_);
    const RTCGeometry instance = Instance(s, inner_, z);
    s.api.rtcCommitGeometry(instance);
    return instance;
  }

  const RTCSceneFlags flags_;
  RTCScene inner_ = nullptr;
  std::vector<RTCGeometry> filtered_;
};

Outcome TraceTower(Tower& tower, const Form& form, Query query, const Judge& geometry,
                   const Judge& context = nullptr) {
  Outcome outcome = TraceRow(tower.s, tower.scene, form, query, geometry, context);
  EXPECT_EQ(outcome.idle_calls, 0);
  return outcome;
}

/// The hits of `rays` are among `offers`.
void ExpectAreOffered(const std::vector<RTCRayHit>& rays, const std::vector<Offer>& offers) {
  for (int i = 0; i < kRays; ++i) {
    if (!MeetsSquare(i)) continue;
    EXPECT_TRUE(std::any_of(
        offers.begin(), offers.end(),
        [&](const Offer& offer) { return offer.ray == i && offer.t == rays[i].ray.tfar; }))
        << "ray " << i;
  }
}

class Filters : public testing::Test {
 protected:
  Tower real{RealEmbree()};
  Tower ours{DropIn()};
};

TEST_F(Filters, AreOfferedEachHitOnceIfTheyRejectAll) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, Reject);
    const Outcome actual = TraceTower(ours, form, query, Reject);
    const std::vector<RTCRayHit> before = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) {
      SCOPED_TRACE("ray " + std::to_string(i));
      EXPECT_TRUE(AreSame(actual.rays[i], before[i]));
      EXPECT_TRUE(AreSame(expected.rays[i], before[i]));
      const auto offers = std::count_if(actual.offers.begin(), actual.offers.end(),
                                        [&](const Offer& offer) { return offer.ray == i; });
      // One a floor, and the far side of the sphere.
      EXPECT_EQ(offers, MeetsSquare(i) ? std::ssize(kTypes) + 1 : 0);
    }
    ExpectSameOffers(actual.offers, expected.offers);
  });
}

TEST_F(Filters, ThatAcceptAllChangeNothing) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, Accept);
    const Outcome actual = TraceTower(ours, form, query, Accept);
    ExpectSameRays(actual.rays, expected.rays);
    for (int i = 0; i < kRays; ++i) {
      if (!MeetsSquare(i)) continue;
      EXPECT_FLOAT_EQ(actual.rays[i].ray.tfar, query == Query::kAny ? -kInfinity : 10);
    }
    // Whatever is seen behind the hit, the hit itself is seen.
    if (query == Query::kClosest) ExpectAreOffered(actual.rays, actual.offers);
  });
}

TEST_F(Filters, LetRaysThroughWhatTheyReject) {
  for (unsigned int first = kFirstId; first <= kInstanceId; ++first) {
    const Judge judge = [=](const Offer& offer) { return TopId(offer.hit) >= first; };
    ForEachCall([&](const Form& form, Query query) {
      const Outcome expected = TraceTower(real, form, query, judge);
      const Outcome actual = TraceTower(ours, form, query, judge);
      ExpectSameRays(actual.rays, expected.rays);
      for (int i = 0; i < kRays; ++i) {
        if (!MeetsSquare(i)) continue;
        if (query == Query::kAny) {
          EXPECT_EQ(actual.rays[i].ray.tfar, -kInfinity);
          continue;
        }
        EXPECT_EQ(actual.rays[i].hit.geomID, first == kInstanceId ? kInnerId : first);
      }
    });
  }
}

TEST_F(Filters, DecideForEachRay) {
  const Judge judge = [](const Offer& offer) {
    return offer.ray % 4 != 0 && static_cast<int>(TopId(offer.hit)) % 4 == offer.ray % 4;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
    const std::vector<RTCRayHit> before = RowOfRays(form);
    for (int i = 0; i < kRays; ++i) {
      const bool is_hit = MeetsSquare(i) && i % 4 != 0;
      EXPECT_EQ(AreSame(actual.rays[i], before[i]), !is_hit) << "ray " << i;
    }
  });
}

TEST_F(Filters, MayChangeTheHit) {
  const Judge judge = [](Offer& offer) {
    offer.hit.u = 0.25f;
    offer.hit.v += 0.5f;
    offer.hit.Ng_x = 3;
    offer.hit.primID += 100;
    offer.hit.geomID += 1000;
    return true;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
    for (int i = 0; i < kRays && query == Query::kClosest; ++i) {
      if (!MeetsSquare(i)) continue;
      EXPECT_EQ(actual.rays[i].hit.u, 0.25f);
      EXPECT_EQ(actual.rays[i].hit.primID, 100u);
      EXPECT_EQ(actual.rays[i].hit.geomID, 1000 + kFirstId);
    }
  });
}

// What lies behind the shortened ray is not hit, though it is before the surface.
TEST_F(Filters, MayShortenTheRay) {
  const Judge judge = [](Offer& offer) {
    if (TopId(offer.hit) % 2 == 0) return false;
    offer.t -= 5;
    return true;
  };
  ForEachCall([&](const Form& form, Query query) {
    if (query == Query::kAny) return;
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
  });
}

TEST_F(Filters, OfGeometriesAreForOneKindOfQuery) {
  for (const Query filtered : {Query::kClosest, Query::kAny}) {
    for (Tower* const tower : {&real, &ours}) tower->SetFilters(filtered);
    ForEachCall([&](const Form& form, Query query) {
      for (Tower* const tower : {&real, &ours}) {
        const Outcome outcome = TraceTower(*tower, form, query, Reject);
        EXPECT_EQ(outcome.offers.empty(), query != filtered);
        EXPECT_EQ(AreSame(outcome.rays[0], RowOfRays(form)[0]), query == filtered);
      }
    });
  }
}

// Packets that are not full, and streams of few rays.
TEST_F(Filters, SeeNoRaysThatAreNotThere) {
  for (const int count : {1, 3, 9}) {
    SCOPED_TRACE(count);
    ForEachCall([&](const Form& form, Query query) {
      const auto trace = [&](Tower& tower) {
        return TraceRow(tower.s, tower.scene, form, query, Reject, nullptr, count);
      };
      const Outcome actual = trace(ours);
      ExpectSameOffers(actual.offers, trace(real).offers);
      EXPECT_EQ(actual.idle_calls, 0);
    });
  }
}

// As with the real library, but for three things: its streams of a single record call with N = 1,
// its calls for 16 rays are made of 8 without AVX-512, and so are its streams.
TEST_F(Filters, AreCalledForAsManyRaysAsTheFormHas) {
  Tower avx2(DropIn(), RTC_SCENE_FLAG_NONE, "isa=avx2");
  ForEachCall([&](const Form& form, Query query) {
    const auto widths_of = [&](Tower& tower) {
      return TraceTower(tower, form, query, Reject).filter_widths;
    };
    if (IsStream(form)) {
      EXPECT_EQ(widths_of(real), std::set{8u});
      EXPECT_EQ(widths_of(avx2), std::set{8u});
      EXPECT_FALSE(widths_of(ours).contains(1));
    } else {
      EXPECT_EQ(widths_of(real), std::set{std::min(form.lanes, 8u)});
      EXPECT_EQ(widths_of(avx2), std::set{form.lanes});
      EXPECT_EQ(widths_of(ours), std::set{form.lanes});
    }
  });
}

TEST_F(Filters, OfStreamsNeverSeeOneRayAlone) {
  for (const Form& form : StreamForms()) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      SCOPED_TRACE(Name(form) + ", " + Name(query));
      const auto widths =
          TraceRow(ours.s, ours.scene, form, query, Reject, nullptr, 1).filter_widths;
      EXPECT_FALSE(widths.empty());
      EXPECT_FALSE(widths.contains(1));
    }
  }
}

// Where the real library stops the program.
TEST(DropInFilters, FirstOnesWaitForACommitOfTheGeometry) {
  Session s(DropIn());
  const RTCGeometry geometry = s.Triangle();
  const RTCScene scene = s.SceneOf(geometry);
  s.api.rtcSetGeometryIntersectFilterFunction(
      geometry,
      [](const RTCFilterFunctionNArguments* args) { std::fill_n(args->valid, args->N, 0); });
  EXPECT_EQ(s.HitGeometry(scene), 0u);
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(s.HitGeometry(scene), RTC_INVALID_GEOMETRY_ID);
}

/// Rays and primitives.
using Pairs = std::vector<std::pair<unsigned int, unsigned int>>;

/// A context for filter functions that note pairs and reject all.
struct PairCall {
  RTCIntersectContext context;
  Pairs pairs;
};

void NotePairs(const RTCFilterFunctionNArguments* args) {
  auto& call = *reinterpret_cast<PairCall*>(const_cast<RTCIntersectContext*>(args->context));
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    args->valid[i] = 0;
    call.pairs.emplace_back(RTCRayN_id(args->ray, args->N, i),
                            RTCHitN_primID(args->hit, args->N, i));
  }
}

/// All pairs of a soup's triangles and rays that meet, in order, as a library offers them in the
/// second call of several: what the first has found out may be kept.
Pairs PairsOfSoup(const Api& api, const char* config, RTCSceneFlags flags, Query query) {
  Session s(api, config);
  const RTCGeometry soup = UncommittedSoup(s, 1, 3000, 0.5f);
  s.api.rtcSetGeometryIntersectFilterFunction(soup, NotePairs);
  s.api.rtcSetGeometryOccludedFilterFunction(soup, NotePairs);
  s.api.rtcCommitGeometry(soup);
  const RTCScene scene = s.NewScene();
  s.api.rtcSetSceneFlags(scene, flags);
  s.api.rtcAttachGeometry(scene, soup);
  s.api.rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = RandomRays(2, 300);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].ray.id = static_cast<unsigned int>(i);
  PairCall call{};
  rtcInitIntersectContext(&call.context);
  for (int repeat = 0; repeat < 2; ++repeat) {
    call.pairs.clear();
    Trace(api, scene, call.context, {Form::Call::kRecords}, query, rays);
  }
  std::sort(call.pairs.begin(), call.pairs.end());
  return call.pairs;
}

class FilteredSoup : public testing::TestWithParam<std::tuple<RTCSceneFlags, Query>> {};
INSTANTIATE_TEST_SUITE_P(, FilteredSoup,
                         testing::Combine(testing::Values(RTC_SCENE_FLAG_NONE,
                                                          RTC_SCENE_FLAG_ROBUST,
                                                          RTC_SCENE_FLAG_COMPACT),
                                          testing::Values(Query::kClosest, Query::kAny)),
                         [](const auto& info) {
                           return std::string(Name(std::get<1>(info.param))) +
                                  std::to_string(std::get<0>(info.param));
                         });

// Some methods cut triangles, or test them again where the subset of rays has changed.
TEST_P(FilteredSoup, IsOfferedPairByPairByEveryMethod) {
  const auto [flags, query] = GetParam();
  const Pairs expected = PairsOfSoup(RealEmbree(), nullptr, flags, query);
  EXPECT_GT(expected.size(), 5000u);
  for (const char* const config :
       {"", "dacrt_budget=0", "dacrt_budget=20000", "dacrt_algorithm=afra2012",
        "dacrt_algorithm=mora2011", "threads=1", "isa=sse4.2"}) {
    SCOPED_TRACE(config);
    const Pairs actual = PairsOfSoup(DropIn(), config, flags, query);
    EXPECT_EQ(std::adjacent_find(actual.begin(), actual.end()), actual.end());
    EXPECT_TRUE(actual == expected) << actual.size() << " pairs, not " << expected.size();
  }
}

class FilterFunction : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(FilterFunction);

TEST_P(FilterFunction, IsNotAskedAboutWhatIsMasked) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.UncommittedTriangle();
  s.api.rtcSetGeometryMask(geometry, 0xFF);
  s.api.rtcSetGeometryUserData(geometry, &s);
  s.api.rtcSetGeometryIntersectFilterFunction(geometry, FilterOfGeometry);
  s.api.rtcSetGeometryOccludedFilterFunction(geometry, FilterOfGeometry);
  s.api.rtcCommitGeometry(geometry);
  const RTCScene scene = s.SceneOf(geometry);
  ForEachCall([&](const Form& form, Query query) {
    const std::vector<RTCRayHit> row = RowOfRays(form);
    std::vector<bool> is_asked(kRays);
    for (const Offer& offer : TraceRow(s, scene, form, query, Accept).offers) {
      is_asked[offer.ray] = true;
    }
    for (int i = 0; i < kRays; ++i) {
      EXPECT_EQ(is_asked[i], MeetsSquare(i) && (row[i].ray.mask & 0xFF) != 0) << "ray " << i;
    }
  });
}

/// Accepts nothing, and expects that rays are in the lanes that their IDs say.
void ExpectOwnLane(const RTCFilterFunctionNArguments* args) {
  auto& call = *reinterpret_cast<PairCall*>(const_cast<RTCIntersectContext*>(args->context));
  for (unsigned int lane = 0; lane < args->N; ++lane) {
    if (args->valid[lane] == 0) continue;
    args->valid[lane] = 0;
    const unsigned int id = RTCRayN_id(args->ray, args->N, lane);
    EXPECT_EQ(id % args->N, lane);
    call.pairs.emplace_back(id, 0);
  }
}

// Programs that trace packets keep what belongs to a ray by its lane.
TEST_P(FilterFunction, SeesRaysOfPacketsInTheirLanes) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.UncommittedTriangle();
  s.api.rtcSetGeometryIntersectFilterFunction(geometry, ExpectOwnLane);
  s.api.rtcSetGeometryOccludedFilterFunction(geometry, ExpectOwnLane);
  s.api.rtcCommitGeometry(geometry);
  const RTCScene scene = s.SceneOf(geometry);
  PairCall call{};
  rtcInitIntersectContext(&call.context);
  const std::size_t valid_rays = TraceThirdsOfPackets(s.api, scene, call.context);
  EXPECT_EQ(call.pairs.size(), valid_rays);
}

/// A context for filter functions that trace rays themselves.
struct NestedCall {
  RTCIntersectContext context;
  const Api& api;
  RTCScene scene;
  bool is_inner;
};

/// Accepts hits that have one other behind them, which it finds out by tracing on.
void AcceptSecondLast(const RTCFilterFunctionNArguments* args) {
  const auto& call = *reinterpret_cast<const NestedCall*>(args->context);
  if (call.is_inner) return;
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    NestedCall inner{{}, call.api, call.scene, true};
    rtcInitIntersectContext(&inner.context);
    RTCRayHit record = RayAt(RTCRayN_org_x(args->ray, args->N, i));
    int behind = 0;
    for (record.ray.tnear = RTCRayN_tfar(args->ray, args->N, i) + 0.5f;; ++behind) {
      record.ray.tfar = 1000;
      record.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      call.api.rtcIntersect1(call.scene, &inner.context, &record);
      if (record.hit.geomID == RTC_INVALID_GEOMETRY_ID) break;
      record.ray.tnear = record.ray.tfar + 0.5f;
    }
    if (behind != 1) args->valid[i] = 0;
  }
}

TEST_P(FilterFunction, MayTraceRays) {
  Session s(GetParam()());
  const RTCScene scene = s.NewScene();
  for (unsigned int layer = 0; layer < 5; ++layer) {
    const RTCGeometry geometry = s.UncommittedTriangle(static_cast<float>(layer));
    s.api.rtcSetGeometryIntersectFilterFunction(geometry, AcceptSecondLast);
    s.api.rtcSetGeometryOccludedFilterFunction(geometry, AcceptSecondLast);
    s.api.rtcCommitGeometry(geometry);
    s.api.rtcAttachGeometry(scene, geometry);
  }
  s.api.rtcCommitScene(scene);
  ForEachCall([&](const Form& form, Query query) {
    NestedCall call{{}, s.api, scene, false};
    rtcInitIntersectContext(&call.context);
    const auto rays = Trace(s.api, scene, call.context, form, query, RowOfRays(form));
    for (int i = 0; i < kRays; ++i) {
      if (!MeetsSquare(i)) continue;
      EXPECT_FLOAT_EQ(rays[i].ray.tfar, query == Query::kClosest ? 13 : -kInfinity);
      EXPECT_EQ(rays[i].hit.geomID, query == Query::kClosest ? 3 : RTC_INVALID_GEOMETRY_ID);
    }
  });
}

/// Notes which threads call.
struct ThreadsCall {
  RTCIntersectContext context;
  std::set<std::thread::id> threads;
};

void NoteThread(const RTCFilterFunctionNArguments* args) {
  auto& call = *reinterpret_cast<ThreadsCall*>(const_cast<RTCIntersectContext*>(args->context));
  call.threads.insert(std::this_thread::get_id());
}

// Programs count in the context, without locks.
TEST(DropInFilters, AreCalledByTheThreadThatTraces) {
  Session s(DropIn(), "threads=4,dacrt_piece_rays=1024");
  const RTCGeometry soup = UncommittedSoup(s, 1, 1000, 0.3f);
  s.api.rtcSetGeometryIntersectFilterFunction(soup, NoteThread);
  s.api.rtcCommitGeometry(soup);
  const RTCScene scene = s.SceneOf(soup);
  const RTCGeometry instance = Instance(s, scene);
  s.api.rtcCommitGeometry(instance);
  for (const RTCScene traced : {scene, s.SceneOf(instance)}) {
    ThreadsCall call{};
    rtcInitIntersectContext(&call.context);
    Trace(s.api, traced, call.context, {Form::Call::kRecords}, Query::kClosest,
          RandomRays(3, 20'000));
    EXPECT_EQ(call.threads, std::set{std::this_thread::get_id()});
  }
}

class ContextFilters : public Filters {
 protected:
  ContextFilters()
      : real_with_flag(RealEmbree(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION),
        ours_with_flag(DropIn(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) {}

  Tower real_with_flag, ours_with_flag;
};

// The real library stops a program that forgets the flag.
TEST_F(ContextFilters, NeedTheFlagOfTheScene) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome outcome = TraceTower(ours, form, query, Accept, Reject);
    EXPECT_TRUE(outcome.context_offers.empty());
    EXPECT_FALSE(AreSame(outcome.rays[0], RowOfRays(form)[0]));
  });
}

// A scene with the flag in one without.
TEST_F(ContextFilters, NeedTheFlagOfAnInstancesScene) {
  RTCScene scenes[2];
  for (Tower* const tower : {&real_with_flag, &ours_with_flag}) {
    const RTCGeometry instance = Instance(tower->s, tower->SceneOfInstance());
    tower->s.api.rtcCommitGeometry(instance);
    scenes[tower == &ours_with_flag] = tower->s.SceneOf(instance);
  }
  ForEachCall([&](const Form& form, Query query) {
    const auto is_odd = [](const Offer& offer) { return offer.ray % 2 != 0; };
    const Outcome expected = TraceRow(real_with_flag.s, scenes[0], form, query, Accept, is_odd);
    const Outcome actual = TraceRow(ours_with_flag.s, scenes[1], form, query, Accept, is_odd);
    ExpectSameOffers(actual.context_offers, expected.context_offers);
    EXPECT_FALSE(actual.context_offers.empty());
    ExpectSameRays(actual.rays, expected.rays);
  });
}

TEST_F(ContextFilters, AreAskedAboutWhatTheGeometrysAccepts) {
  const auto is_odd = [](const Offer& offer) { return TopId(offer.hit) % 2 != 0; };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real_with_flag, form, query, is_odd, Reject);
    const Outcome actual = TraceTower(ours_with_flag, form, query, is_odd, Reject);
    ExpectSameOffers(actual.offers, expected.offers);
    ExpectSameOffers(actual.context_offers, expected.context_offers);
    EXPECT_TRUE(std::all_of(actual.context_offers.begin(), actual.context_offers.end(), is_odd));
    EXPECT_TRUE(AreSame(actual.rays[0], RowOfRays(form)[0]));
  });
}

TEST_F(ContextFilters, SeeWhatTheGeometrysChanged) {
  const Judge geometry_judge = [](Offer& offer) {
    offer.hit.u = 0.25f;
    offer.t -= 0.5f;
    return true;
  };
  const Judge context_judge = [](Offer& offer) {
    EXPECT_EQ(offer.hit.u, 0.25f);
    offer.hit.v = 0.75f;
    return TopId(offer.hit) > kFirstId + 2;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real_with_flag, form, query, geometry_judge, context_judge);
    const Outcome actual = TraceTower(ours_with_flag, form, query, geometry_judge, context_judge);
    ExpectSameRays(actual.rays, expected.rays);
    if (query == Query::kAny) return;
    EXPECT_EQ(TopId(actual.rays[0].hit), kFirstId + 3);
    EXPECT_EQ(actual.rays[0].hit.u, 0.25f);
    EXPECT_EQ(actual.rays[0].hit.v, 0.75f);
  });
}

}  // namespace
}  // namespace dacrt::tests
