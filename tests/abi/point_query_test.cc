// Point queries: what both libraries must offer, and the nearest point that a program finds with
// them.
//
// The real library offers all primitives of a leaf of its BVH, and a grid once for each part of it;
// dacrt offers what lies within the radius, once. So sets are compared with brute force only.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <thread>
#include <tuple>
#include <vector>

#include "point_query.h"
#include "point_scene.h"

namespace dacrt::tests {
namespace {

Point PointOf(const RTCPointQuery& query) { return {query.x, query.y, query.z}; }

Key KeyOf(const RTCPointQueryFunctionArguments& args) {
  const unsigned int instance =
      args.context->instStackSize > 0 ? args.context->instID[0] : RTC_INVALID_GEOMETRY_ID;
  return {instance, args.geomID, args.primID};
}

/// What a function was called for. Given as the user pointer.
struct Collection {
  const PointScene* scene = nullptr;
  bool shrinks = false;
  std::map<Key, int> offered = {};
  Key nearest = {};
};

/// Checks what the context says of the instance.
void CheckInstance(const RTCPointQueryFunctionArguments& args, const PointScene& scene) {
  const RTCPointQueryContext& context = *args.context;
  if (context.instStackSize == 0) {
    EXPECT_EQ(args.similarityScale, 1);
    EXPECT_EQ(context.instID[0], RTC_INVALID_GEOMETRY_ID);
    return;
  }
  EXPECT_EQ(context.instStackSize, 1u);
  ASSERT_TRUE(scene.instances.contains(context.instID[0]));
  const InstanceModel& instance = scene.instances.at(context.instID[0]);
  EXPECT_NEAR(args.similarityScale, instance.scale, 1e-5);
  const Point local{0.25, -0.5, 1};
  const Point want =
      Mix(Apply(instance.begin, local), Apply(instance.end, local), args.query->time);
  const Point world = Apply4x4(context.inst2world[0], local);
  const Point back = Apply4x4(context.world2inst[0], world);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(world[i], want[i], 1e-5);
    EXPECT_NEAR(back[i], local[i], 1e-5);
  }
}

/// As far from the candidate as the query's point is, measured as the manual says: in the instance
/// where it is a similarity, else in the world.
double DistanceOf(const RTCPointQueryFunctionArguments& args, const Item& item) {
  const Point point = PointOf(*args.query);
  if (args.context->instStackSize > 0 && args.similarityScale > 0) {
    return Distance(Apply4x4(args.context->world2inst[0], point), item.local) /
           args.similarityScale;
  }
  return Distance(point, item.At(args.query->time));
}

bool Collect(RTCPointQueryFunctionArguments* args) {
  auto& collection = *static_cast<Collection*>(args->userPtr);
  CheckInstance(*args, *collection.scene);
  const Key key = KeyOf(*args);
  ++collection.offered[key];
  const auto item = collection.scene->items.find(key);
  if (item == collection.scene->items.end()) {
    ADD_FAILURE() << "instance " << std::get<0>(key) << ", geometry " << std::get<1>(key);
    return false;
  }
  if (!collection.shrinks || !item->second.IsThereAt(args->query->time)) return false;
  const double distance = DistanceOf(*args, item->second);
  if (!(distance < args->query->radius)) return false;
  args->query->radius = static_cast<float>(distance);
  collection.nearest = key;
  return true;
}

class PointQueries : public PointQueryTest {};

INSTANTIATE_ON_BOTH_LIBRARIES(PointQueries);

constexpr float kTimes[] = {0, 0.2f, 0.3f, 0.5f, 1};

/// The distance of a point from the box around triangles.
double DistanceFromBox(const Point& p, const std::vector<Triangle>& triangles) {
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    for (const Triangle& triangle : triangles) {
      for (const Point& corner : triangle) {
        lower = std::min(lower, corner[axis]);
        upper = std::max(upper, corner[axis]);
      }
    }
    const double beyond = std::max({lower - p[axis], p[axis] - upper, 0.0});
    square += beyond * beyond;
  }
  return std::sqrt(square);
}

void ExpectWhatLiesWithin(Session& s, PointScene& scene, bool is_ours) {
  for (int i = 0; i < 60; ++i) {
    const float time = kTimes[i % std::size(kTimes)];
    const float radius = std::array{0.0f, 0.5f, 2.0f, 8.0f}[i % 4];
    RTCPointQuery query = QueryAt(scene.RandomPoint(), radius, time);
    const Point point = PointOf(query);
    Collection collection{&scene};
    EXPECT_FALSE(Query(s.api, scene.scene, query, Collect, &collection));
    EXPECT_EQ(query.radius, radius);
    for (const auto& [key, item] : scene.items) {
      const auto& [instance, geometry, primitive] = key;
      const bool is_offered = collection.offered.contains(key);
      const auto where = testing::Message()
                         << "query " << i << ", instance " << instance << ", geometry " << geometry
                         << ", primitive " << primitive;
      const auto triangles = item.At(time);
      if (item.IsThereAt(time) && Distance(point, triangles) <= radius) {
        EXPECT_TRUE(is_offered) << where;
      }
      if (!is_ours || !is_offered) continue;
      EXPECT_EQ(collection.offered[key], 1) << where;
      EXPECT_TRUE(item.IsThereAt(time)) << where;
      // What is not in an instance is offered by its bounds, with nothing but rounding beside it.
      // The bounds of what moves do so themselves, and are wider.
      if (instance == RTC_INVALID_GEOMETRY_ID && !item.is_moving) {
        EXPECT_LE(DistanceFromBox(point, triangles), radius * 1.0001 + 1e-6) << where;
      }
    }
    for (const auto& [key, count] : collection.offered) {
      if (std::get<0>(key) == RTC_INVALID_GEOMETRY_ID) {
        EXPECT_FALSE(scene.unseen.contains(std::get<1>(key)));
      }
    }
    if (testing::Test::HasFailure()) return;
  }
}

TEST_P(PointQueries, OfferWhatLiesWithinTheRadius) {
  PointScene scene(s_, 1);
  ExpectWhatLiesWithin(s_, scene, IsOurs());
}

TEST_P(PointQueries, OfferWhatLiesWithinTheRadiusOfACompactScene) {
  PointScene scene(s_, 2, RTC_SCENE_FLAG_COMPACT);
  ExpectWhatLiesWithin(s_, scene, IsOurs());
}

TEST_P(PointQueries, OfferEverythingWithinInfinity) {
  PointScene scene(s_, 3);
  RTCPointQuery query = QueryAt(scene.RandomPoint(), std::numeric_limits<float>::infinity(), 0.5f);
  Collection collection{&scene};
  Query(s_.api, scene.scene, query, Collect, &collection);
  EXPECT_EQ(collection.offered.size(), scene.items.size());
}

void ExpectNearest(Session& s, PointScene& scene) {
  for (int i = 0; i < 100; ++i) {
    const float time = kTimes[i % std::size(kTimes)];
    const float radius = i % 2 == 0 ? std::numeric_limits<float>::infinity() : 3.0f;
    RTCPointQuery query = QueryAt(scene.RandomPoint(), radius, time);
    double nearest = radius;
    for (const auto& [key, item] : scene.items) {
      if (!item.IsThereAt(time)) continue;
      nearest = std::min(nearest, Distance(PointOf(query), item.At(time)));
    }
    Collection collection{&scene, true};
    const bool changed = Query(s.api, scene.scene, query, Collect, &collection);
    EXPECT_EQ(changed, nearest < radius);
    ASSERT_NEAR(query.radius, nearest, 1e-5 * (1 + nearest)) << "query " << i;
    if (!changed) continue;
    const Item& item = scene.items.at(collection.nearest);
    EXPECT_NEAR(Distance(PointOf(query), item.At(time)), nearest, 1e-5 * (1 + nearest));
  }
}

TEST_P(PointQueries, FindTheNearestPoint) {
  for (unsigned int seed = 10; seed < 14; ++seed) {
    PointScene scene(s_, seed);
    ExpectNearest(s_, scene);
  }
}

TEST_P(PointQueries, FindTheNearestPointFromSeveralThreads) {
  // Each scene is new, so that the threads meet where dacrt partitions it.
  for (unsigned int seed = 20; seed < 24; ++seed) {
    PointScene scene(s_, seed);
    const std::vector<Point> points = [&] {
      std::vector<Point> random;
      for (int i = 0; i < 200; ++i) random.push_back(scene.RandomPoint());
      return random;
    }();
    const auto find_all = [&](std::vector<float>& radii) {
      for (const Point& point : points) {
        RTCPointQuery query = QueryAt(point, std::numeric_limits<float>::infinity());
        Collection collection{&scene, true};
        Query(s_.api, scene.scene, query, Collect, &collection);
        radii.push_back(query.radius);
      }
    };
    std::array<std::vector<float>, 4> radii;
    {
      std::vector<std::jthread> threads;
      for (auto& own : radii) threads.emplace_back([&] { find_all(own); });
    }
    for (const auto& own : radii) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(own[i], radii[0][i], 1e-5f * (1 + radii[0][i]));
      }
    }
  }
}

/// Packets of `kLanes` queries, each lane as a query alone.
template <int kLanes, class Packet, class Call>
void ExpectLanesToBeQueries(Session& s, PointScene& scene, Call call) {
  for (int round = 0; round < 10; ++round) {
    alignas(64) Packet packet;
    alignas(64) int valid[kLanes];
    Collection collections[kLanes];
    void* user_pointers[kLanes];
    RTCPointQuery queries[kLanes];
    const int flags[] = {-1, 0, 1, std::numeric_limits<int>::min()};  // all but 0 are valid
    for (int i = 0; i < kLanes; ++i) {
      queries[i] = QueryAt(scene.RandomPoint(), 5, kTimes[i % std::size(kTimes)]);
      packet.x[i] = queries[i].x;
      packet.y[i] = queries[i].y;
      packet.z[i] = queries[i].z;
      packet.time[i] = queries[i].time;
      packet.radius[i] = queries[i].radius;
      valid[i] = round == 0 ? 0 : flags[(i + round) % 4];
      collections[i] = {&scene, true};
      user_pointers[i] = &collections[i];
    }
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const bool changed = call(valid, scene.scene, &packet, &context, Collect, user_pointers);
    bool any_changed = false;
    for (int i = 0; i < kLanes; ++i) {
      Collection alone{&scene, true};
      if (valid[i] != 0) {
        any_changed |= Query(s.api, scene.scene, queries[i], Collect, &alone);
      }
      EXPECT_EQ(packet.radius[i], queries[i].radius);
      EXPECT_EQ(packet.x[i], queries[i].x);
      EXPECT_EQ(collections[i].offered, alone.offered);
    }
    EXPECT_EQ(changed, any_changed);
    if (testing::Test::HasFailure()) return;
  }
}

TEST_P(PointQueries, PacketsAreQueriesLaneByLane) {
  PointScene scene(s_, 30);
  const Api& api = s_.api;
  ExpectLanesToBeQueries<4, RTCPointQuery4>(
      s_, scene, [&](auto... args) { return api.rtcPointQuery4(args...); });
  ExpectLanesToBeQueries<8, RTCPointQuery8>(
      s_, scene, [&](auto... args) { return api.rtcPointQuery8(args...); });
  ExpectLanesToBeQueries<16, RTCPointQuery16>(
      s_, scene, [&](auto... args) { return api.rtcPointQuery16(args...); });
}

}  // namespace
}  // namespace dacrt::tests
