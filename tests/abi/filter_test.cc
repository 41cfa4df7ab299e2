// Filter functions of geometries and of contexts, in every form of a call, on both libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include "forms.h"
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

constexpr int kRays = 40;
bool Misses(int i) { return i % 10 == 7; }
bool IsInactive(int i) { return i == 13; }
bool MeetsTower(int i) { return !Misses(i) && !IsInactive(i); }

/// Ray i of a batch. It meets every geometry of the tower, unless it is one of the above.
RTCRayHit RayNumber(int i) {
  RTCRayHit record = RayAt((Misses(i) ? 5 : 0.3f) + 0.01f * static_cast<float>(i));
  record.ray.id = 100 + i;
  record.ray.flags = 200 + i;
  record.ray.mask = 0x10001u << i % 16;
  record.hit.u = 7;
  if (IsInactive(i)) {
    record.ray.tnear = 2;
    record.ray.tfar = 1;  // before the tower, for the form without tnear
  }
  return record;
}

std::vector<RTCRayHit> Batch(const Form& form) {
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < kRays; ++i) rays.push_back(RayNumber(i));
  ReplaceAbsent(form, rays);
  return rays;
}

/// The number of the ray that starts at this x, whatever its ID.
int NumberOf(float org_x) {
  return static_cast<int>(std::lround((org_x - (org_x > 4 ? 5 : 0.3f)) * 100));
}

/// A hit that a filter function is asked about.
struct Offer {
  int ray;
  float t;
  RTCHit hit;
};

/// What a filter function answers: whether it accepts the hit, which it may have changed.
using Judge = std::function<bool(Offer&)>;

/// A context with what the filter functions need, and what they note, behind it.
struct Call {
  RTCIntersectContext context;
  const std::vector<RTCRayHit>* rays;
  Judge geometry_judge, context_judge;
  std::vector<Offer> offers, context_offers;
  std::set<unsigned int> widths;
};

/// A ray as a filter function sees it is the caller's. An instance's geometries see it moved.
void ExpectIsRay(const RTCRay& seen, const RTCRay& ray, bool in_instance) {
  EXPECT_EQ(seen.org_y, ray.org_y);
  if (!in_instance) {
    EXPECT_EQ(seen.org_z, ray.org_z);
  }
  EXPECT_EQ(seen.tnear, ray.tnear);
  EXPECT_EQ(seen.dir_x, ray.dir_x);
  EXPECT_EQ(seen.dir_z, ray.dir_z);
  EXPECT_EQ(seen.time, ray.time);
  EXPECT_EQ(seen.mask, ray.mask);
  EXPECT_EQ(seen.id, ray.id);
  EXPECT_EQ(seen.flags, ray.flags);
}

void Filter(const RTCFilterFunctionNArguments& args, Call& call, const Judge& judge,
            std::vector<Offer>& offers) {
  call.widths.insert(args.N);
  EXPECT_NE(std::count(args.valid, args.valid + args.N, 0), args.N) << "called for nothing";
  for (unsigned int i = 0; i < args.N; ++i) {
    if (args.valid[i] == 0) continue;
    EXPECT_EQ(args.valid[i], -1);
    const RTCRay ray = rtcGetRayFromRayN(args.ray, args.N, i);
    Offer offer{NumberOf(ray.org_x), ray.tfar, rtcGetHitFromHitN(args.hit, args.N, i)};
    ASSERT_GE(offer.ray, 0);
    ASSERT_LT(offer.ray, kRays);
    const unsigned int instance = args.context->instID[0];
    EXPECT_EQ(offer.hit.instID[0], instance);
    ExpectIsRay(ray, (*call.rays)[offer.ray].ray, instance != RTC_INVALID_GEOMETRY_ID);
    offers.push_back(offer);
    if (!judge(offer)) {
      args.valid[i] = 0;
      continue;
    }
    rtcCopyHitToHitN(args.hit, &offer.hit, args.N, i);
    RTCRayN_tfar(args.ray, args.N, i) = offer.t;
  }
}

Call& CallOf(const RTCFilterFunctionNArguments* args) {
  return *reinterpret_cast<Call*>(const_cast<RTCIntersectContext*>(args->context));
}

void FilterOfGeometry(const RTCFilterFunctionNArguments* args) {
  Call& call = CallOf(args);
  // A tower's geometries have their type for user data.
  EXPECT_NE(args->geometryUserPtr, nullptr);
  Filter(*args, call, call.geometry_judge, call.offers);
}

void FilterOfContext(const RTCFilterFunctionNArguments* args) {
  Call& call = CallOf(args);
  Filter(*args, call, call.context_judge, call.context_offers);
}

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
    const RTCScene inner = s.NewScene();
    s.api.rtcSetSceneFlags(inner, flags_);
    s.api.rtcAttachGeometryByID(inner, Floor(kTypes[0], 0), kInnerId);
    s.api.rtcCommitScene(inner);
    const RTCGeometry instance = Instance(s, inner, z);
    s.api.rtcCommitGeometry(instance);
    return instance;
  }

  const RTCSceneFlags flags_;
  std::vector<RTCGeometry> filtered_;
};

bool Accept(Offer&) { return true; }
bool Reject(Offer&) { return false; }

/// What is left of a call.
struct Outcome {
  std::vector<RTCRayHit> rays;
  std::vector<Offer> offers, context_offers;
  std::set<unsigned int> widths;
};

Outcome TraceTower(Tower& tower, const Form& form, Query query, const Judge& geometry_judge,
                   const Judge& context_judge = nullptr, int count = kRays) {
  std::vector<RTCRayHit> rays = Batch(form);
  rays.resize(count);
  Call call{{}, &rays, geometry_judge, context_judge, {}, {}, {}};
  rtcInitIntersectContext(&call.context);
  if (context_judge) call.context.filter = FilterOfContext;
  auto traced = Trace(tower.s.api, tower.scene, call.context, form, query, rays);
  EXPECT_EQ(tower.s.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(call.context.instID[0], RTC_INVALID_GEOMETRY_ID);
  return {std::move(traced), std::move(call.offers), std::move(call.context_offers),
          std::move(call.widths)};
}

/// The geometry of the tower that was hit; of an instance, the instance.
unsigned int FloorOf(const RTCHit& hit) {
  return hit.instID[0] == RTC_INVALID_GEOMETRY_ID ? hit.geomID : hit.instID[0];
}

auto KeyOf(const Offer& offer) { return std::tuple(offer.ray, FloorOf(offer.hit), offer.t); }

void Sort(std::vector<Offer>& offers) {
  std::sort(offers.begin(), offers.end(),
            [](const Offer& a, const Offer& b) { return KeyOf(a) < KeyOf(b); });
}

/// Nothing but rounding differs. The normals of spheres inherit that of the distance.
void ExpectSameHit(const RTCHit& ours, const RTCHit& real, float t) {
  constexpr float kUlp = std::numeric_limits<float>::epsilon();
  EXPECT_EQ(ours.geomID, real.geomID);
  EXPECT_EQ(ours.primID, real.primID);
  EXPECT_EQ(ours.instID[0], real.instID[0]);
  EXPECT_NEAR(ours.u, real.u, 4 * kUlp);
  EXPECT_NEAR(ours.v, real.v, 4 * kUlp);
  EXPECT_NEAR(ours.Ng_x, real.Ng_x, 4 * kUlp);
  EXPECT_NEAR(ours.Ng_y, real.Ng_y, 4 * kUlp);
  EXPECT_NEAR(ours.Ng_z, real.Ng_z, 2 * kUlp * t);
}

void ExpectSameOffers(std::vector<Offer> ours, std::vector<Offer> real) {
  Sort(ours);
  Sort(real);
  ASSERT_EQ(ours.size(), real.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(ours[i].ray, real[i].ray);
    EXPECT_FLOAT_EQ(ours[i].t, real[i].t);
    ExpectSameHit(ours[i].hit, real[i].hit, real[i].t);
  }
}

bool AreSame(const RTCRayHit& a, const RTCRayHit& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void ExpectSameRays(const std::vector<RTCRayHit>& ours, const std::vector<RTCRayHit>& real) {
  for (std::size_t i = 0; i < ours.size(); ++i) {
    SCOPED_TRACE("ray " + std::to_string(i));
    EXPECT_FLOAT_EQ(ours[i].ray.tfar, real[i].ray.tfar);
    ExpectSameHit(ours[i].hit, real[i].hit, std::abs(real[i].ray.tfar));
  }
}

/// The hits of `rays` are among `offers`.
void ExpectAreOffered(const std::vector<RTCRayHit>& rays, const std::vector<Offer>& offers) {
  for (int i = 0; i < kRays; ++i) {
    if (!MeetsTower(i)) continue;
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

  /// Runs `body` for every form and query.
  template <class Body>
  void ForEachCall(const Body& body) {
    for (const Form& form : AllForms()) {
      for (const Query query : {Query::kClosest, Query::kAny}) {
        SCOPED_TRACE(Name(form) + ", " + Name(query));
        body(form, query);
        if (HasFailure()) return;
      }
    }
  }
};

TEST_F(Filters, AreOfferedEachHitOnceIfTheyRejectAll) {
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, Reject);
    const Outcome actual = TraceTower(ours, form, query, Reject);
    const std::vector<RTCRayHit> before = Batch(form);
    for (int i = 0; i < kRays; ++i) {
      SCOPED_TRACE("ray " + std::to_string(i));
      EXPECT_TRUE(AreSame(actual.rays[i], before[i]));
      EXPECT_TRUE(AreSame(expected.rays[i], before[i]));
      const auto offers = std::count_if(actual.offers.begin(), actual.offers.end(),
                                        [&](const Offer& offer) { return offer.ray == i; });
      // One a floor, and the far side of the sphere.
      EXPECT_EQ(offers, MeetsTower(i) ? std::ssize(kTypes) + 1 : 0);
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
      if (!MeetsTower(i)) continue;
      EXPECT_FLOAT_EQ(actual.rays[i].ray.tfar, query == Query::kAny ? -kInfinity : 10);
    }
    // Whatever is seen behind the hit, the hit itself is seen.
    if (query == Query::kClosest) ExpectAreOffered(actual.rays, actual.offers);
  });
}

TEST_F(Filters, LetRaysThroughWhatTheyReject) {
  for (unsigned int first = kFirstId; first <= kInstanceId; ++first) {
    const Judge judge = [=](const Offer& offer) { return FloorOf(offer.hit) >= first; };
    ForEachCall([&](const Form& form, Query query) {
      const Outcome expected = TraceTower(real, form, query, judge);
      const Outcome actual = TraceTower(ours, form, query, judge);
      ExpectSameRays(actual.rays, expected.rays);
      for (int i = 0; i < kRays; ++i) {
        if (!MeetsTower(i)) continue;
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
    return offer.ray % 4 != 0 && static_cast<int>(FloorOf(offer.hit)) % 4 == offer.ray % 4;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real, form, query, judge);
    const Outcome actual = TraceTower(ours, form, query, judge);
    ExpectSameRays(actual.rays, expected.rays);
    const std::vector<RTCRayHit> before = Batch(form);
    for (int i = 0; i < kRays; ++i) {
      const bool is_hit = MeetsTower(i) && i % 4 != 0;
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
      if (!MeetsTower(i)) continue;
      EXPECT_EQ(actual.rays[i].hit.u, 0.25f);
      EXPECT_EQ(actual.rays[i].hit.primID, 100u);
      EXPECT_EQ(actual.rays[i].hit.geomID, 1000 + kFirstId);
    }
  });
}

// What lies behind the shortened ray is not hit, though it is before the surface.
TEST_F(Filters, MayShortenTheRay) {
  const Judge judge = [](Offer& offer) {
    if (FloorOf(offer.hit) % 2 == 0) return false;
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
        EXPECT_EQ(AreSame(outcome.rays[0], Batch(form)[0]), query == filtered);
      }
    });
  }
}

// As with the real library, but for three things: its streams of a single record call with N = 1,
// its calls for 16 rays are made of 8 without AVX-512, and so are its streams.
TEST_F(Filters, AreCalledForAsManyRaysAsTheFormHas) {
  Tower avx2(DropIn(), RTC_SCENE_FLAG_NONE, "isa=avx2");
  ForEachCall([&](const Form& form, Query query) {
    const auto widths_of = [&](Tower& tower) {
      return TraceTower(tower, form, query, Reject).widths;
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
      const auto widths = TraceTower(ours, form, query, Reject, nullptr, 1).widths;
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

/// Filter functions that note pairs of ray and primitive, and reject all, behind a context.
struct PairCall {
  RTCIntersectContext context;
  std::vector<std::pair<unsigned int, unsigned int>> pairs;
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

/// All pairs of a soup's triangles and rays that meet, in order, as a library offers them.
std::vector<std::pair<unsigned int, unsigned int>> PairsOfSoup(const Api& api, const char* config,
                                                               Query query) {
  Session s(api, config);
  const RTCGeometry soup = UncommittedSoup(s, 1, 3000, 0.5f);
  s.api.rtcSetGeometryIntersectFilterFunction(soup, NotePairs);
  s.api.rtcSetGeometryOccludedFilterFunction(soup, NotePairs);
  s.api.rtcCommitGeometry(soup);
  const RTCScene scene = s.SceneOf(soup);
  std::vector<RTCRayHit> rays = RandomRays(2, 300);
  for (std::size_t i = 0; i < rays.size(); ++i) rays[i].ray.id = static_cast<unsigned int>(i);
  PairCall call{};
  rtcInitIntersectContext(&call.context);
  Trace(api, scene, call.context, {Form::Call::kRecords}, query, rays);
  std::sort(call.pairs.begin(), call.pairs.end());
  return call.pairs;
}

// Some methods cut triangles, or test them again where the subset of rays has changed.
TEST(DropInFilters, AreOfferedEachPairOnceByEveryMethod) {
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const auto expected = PairsOfSoup(RealEmbree(), nullptr, query);
    EXPECT_GT(expected.size(), 5000u);
    for (const char* const config :
         {"", "dacrt_budget=0", "dacrt_budget=20000", "dacrt_algorithm=afra2012",
          "dacrt_algorithm=mora2011", "threads=1", "isa=sse4.2"}) {
      SCOPED_TRACE(config);
      const auto actual = PairsOfSoup(DropIn(), config, query);
      EXPECT_EQ(std::adjacent_find(actual.begin(), actual.end()), actual.end());
      EXPECT_TRUE(actual == expected) << actual.size() << " pairs, not " << expected.size();
    }
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
    EXPECT_FALSE(AreSame(outcome.rays[0], Batch(form)[0]));
  });
}

TEST_F(ContextFilters, AreAskedAboutWhatTheGeometrysAccepts) {
  const auto is_odd = [](const Offer& offer) { return FloorOf(offer.hit) % 2 != 0; };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real_with_flag, form, query, is_odd, Reject);
    const Outcome actual = TraceTower(ours_with_flag, form, query, is_odd, Reject);
    ExpectSameOffers(actual.offers, expected.offers);
    ExpectSameOffers(actual.context_offers, expected.context_offers);
    EXPECT_TRUE(std::all_of(actual.context_offers.begin(), actual.context_offers.end(), is_odd));
    EXPECT_TRUE(AreSame(actual.rays[0], Batch(form)[0]));
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
    return FloorOf(offer.hit) > kFirstId + 2;
  };
  ForEachCall([&](const Form& form, Query query) {
    const Outcome expected = TraceTower(real_with_flag, form, query, geometry_judge, context_judge);
    const Outcome actual = TraceTower(ours_with_flag, form, query, geometry_judge, context_judge);
    ExpectSameRays(actual.rays, expected.rays);
    if (query == Query::kAny) return;
    EXPECT_EQ(FloorOf(actual.rays[0].hit), kFirstId + 3);
    EXPECT_EQ(actual.rays[0].hit.u, 0.25f);
    EXPECT_EQ(actual.rays[0].hit.v, 0.75f);
  });
}

}  // namespace
}  // namespace dacrt::tests
