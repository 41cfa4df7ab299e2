// Filter functions as a program writes them: what they are asked about, in which lanes, by which
// thread, and that they may trace.
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
  const RTCGeometry instance = Instance(s, scene);
  s.api.rtcCommitGeometry(instance);
  for (const RTCScene traced : {scene, s.SceneOf(instance)}) {
    PairCall call{};
    rtcInitIntersectContext(&call.context);
    const std::size_t valid_rays = TraceThirdsOfPackets(s, traced, call.context);
    EXPECT_EQ(call.pairs.size(), valid_rays);
  }
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

}  // namespace
}  // namespace dacrt::tests
