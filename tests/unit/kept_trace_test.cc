// Scene::Trace over kept partitions through the public API: the same bits for every budget, every
// form of call, every number of rays a call and every number of threads, in scenes of all shapes.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "every_shape.h"
#include "kept_trace.h"
#include "partition/kept_partition.h"
#include "shape_scenes.h"
#include "trace/policy.h"

namespace dacrt::unit {
namespace {

using enum PacketComponent;

INSTANTIATE_ON_EACH_INSTRUCTION_SET(KeptTraceTest);

/// Nothing, the least, one that ends somewhere on the way, and more than it takes.
const uint64_t kBudgets[] = {0, 1, 18000, 8 * 3000, kDefaultBudget, kUnlimitedBudget};

// Every shape in one scene, with every budget: subsets that stay unsplit, partitions that are
// forgotten, leaves with and without geometry.
TEST_P(KeptTraceTest, BudgetsDoNotChangeABit) {
  Random random(1);
  const auto rays = MakeFullRays(random, 300);
  for (int kind = 0; kind < 12; ++kind) {
    WorldScene::Options options;
    options.has_callbacks = kind % 3 == 2;
    options.has_instances = kind % 3 >= 1;
    options.robust = kind % 6 >= 3;
    options.is_small = kind >= 6;
    const WorldScene pure(WithBudget(0), options);
    ASSERT_EQ(pure.scene->KeptBytes(), 0u);
    const auto expected = TraceForm(*pure.scene, rays, Query::kClosest);
    const auto expected_any = TraceForm(*pure.scene, rays, Query::kAny);
    std::set<uint32_t> geometries, instances;
    for (const FullRay& ray : expected) {
      geometries.insert(ray.Get<uint32_t>(kGeometryId));
      instances.insert(ray.Get<uint32_t>(kInstanceId));
    }
    EXPECT_GE(geometries.size(), options.is_small ? 4u : 8u);
    EXPECT_EQ(instances.size(), options.has_instances ? 4u : 1u);
    for (const uint64_t budget : kBudgets) {
      for (const Keep keep : {Keep::kByBudget, Keep::kLittle}) {
        if (keep == Keep::kLittle && budget != kDefaultBudget) continue;
        options.keep = keep;
        const std::string what = "kind " + std::to_string(kind) + ", budget " +
                                 std::to_string(budget) + (keep == Keep::kLittle ? ", little" : "");
        const WorldScene world(WithBudget(budget, 2), options);
        const Scene& scene = *world.scene;
        ASSERT_EQ(scene.KeptBytes() > 0, budget > 0);
        ExpectSame(TraceForm(scene, rays, Query::kClosest), expected, what);
        ExpectSame(TraceForm(scene, rays, Query::kAny), expected_any, what + ", any");
        ASSERT_LE(scene.KeptBytesUsed(), scene.KeptBytes());
        for (const uint32_t lanes : {1u, 4u}) {
          ExpectSame(TracePackets(scene, rays, Query::kClosest, lanes, nullptr), expected,
                     what + ", packets of " + std::to_string(lanes));
          ExpectSame(TracePackets(scene, rays, Query::kAny, lanes, nullptr), expected_any,
                     what + ", any, packets of " + std::to_string(lanes));
        }
        if (keep == Keep::kLittle) continue;
        // The short way, through what the large call has left, and through nothing.
        const WorldScene fresh(WithBudget(budget), options);
        ExpectSame(TraceInCalls(*fresh.scene, rays, Query::kClosest, 64), expected,
                   what + ", by 64");
        ExpectSame(TraceInCalls(scene, rays, Query::kAny, 64), expected_any, what + ", by 64");
        if (HasFatalFailure()) return;
      }
    }
  }
}

// Streams in every form, packets of every width with any lanes, and single rays.
TEST_P(KeptTraceTest, PacketsSinglesAndStreamsAgree) {
  Random random(2);
  const auto rays = MakeFullRays(random, 130);
  for (const auto& [has_callbacks, is_small] : {std::pair(false, false), std::pair(true, false),
                                                std::pair(false, true), std::pair(true, true)}) {
    for (const uint64_t budget : {uint64_t{0}, uint64_t{1}, kDefaultBudget}) {
      WorldScene::Options options;
      options.has_callbacks = has_callbacks;
      options.is_small = is_small;
      const WorldScene world(WithBudget(budget), options);
      const Scene& scene = *world.scene;
      for (const Query query : {Query::kClosest, Query::kAny}) {
        const std::string what =
            "budget " + std::to_string(budget) + (has_callbacks ? ", callbacks" : "") +
            (is_small ? ", small" : "") + (query == Query::kAny ? ", any" : "");
        const auto expected = TraceForm(scene, rays, query);
        ASSERT_NE(expected, rays);
        for (const Form& form : AllForms()) {
          if (budget == 1 && form.lanes % 4 != 0) continue;
          ExpectSame(TraceForm(scene, rays, query, form), expected, what + ", " + form.Text());
          if (HasFatalFailure()) return;
        }
        for (uint32_t lanes = 1; lanes <= 16; ++lanes) {
          if (budget != kDefaultBudget && lanes % 4 != 1) continue;
          const std::string packets = what + ", packets of " + std::to_string(lanes);
          ExpectSame(TracePackets(scene, rays, query, lanes, nullptr), expected, packets);
          std::vector<int32_t> valid;
          auto some = rays;
          for (std::size_t i = 0; i < rays.size(); ++i) {
            // Only -1 takes part.
            const int32_t kinds[] = {-1, -1, 0, 1};
            valid.push_back(kinds[random.Below(4)]);
            if (valid[i] == -1) some[i] = expected[i];
          }
          ExpectSame(TracePackets(scene, rays, query, lanes, &valid), some, packets + ", some");
          if (HasFatalFailure()) return;
        }
      }
    }
  }
}

// Scenes that are small and hold nothing but triangles, of which some coincide; half of the rays
// run in one direction, and half end where they hit something, or right before. Calls of every
// size, too, whose rays have next to nothing in common. Single rays of scenes whose leaves are made
// for each visit meet the same.
TEST_P(KeptTraceTest, TrianglesMeetPacketsAsTheyMeetRays) {
  Random random(13);
  for (const std::size_t triangles : {std::size_t{36}, std::size_t{400}, std::size_t{20000}}) {
    Mesh mesh = MakeSoup(random, triangles, 2, triangles < 1000 ? 0.6f : 0.1f);
    for (std::size_t i = 0; i < triangles; i += 8) mesh.triangles.push_back(mesh.triangles[i]);
    const auto device = std::make_shared<Device>(WithBudget(kDefaultBudget));
    const Scene scene(device, {{mesh.View()}}), little(device, {{mesh.View()}}, Keep::kLittle);
    auto rays = MakeFullRays(random, 600);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (i % 16 < 8) {
        rays[i].Set(kDirX, 0.1f);
        rays[i].Set(kDirY, random.Uniform(-0.01f, 0.01f));
        rays[i].Set(kDirZ, 1.0f);
      }
    }
    const auto closest = TracePackets(scene, rays, Query::kClosest, 1, nullptr);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (closest[i] == rays[i] || i % 4 >= 2) continue;
      const float t = closest[i].Get(kTfar);
      rays[i].Set(kTfar, i % 4 == 0 ? t : std::nextafter(t, 0.0f));
    }
    for (const Query query : {Query::kClosest, Query::kAny}) {
      const auto expected = TracePackets(scene, rays, query, 1, nullptr);
      const std::string what = std::to_string(triangles) + (query == Query::kAny ? ", any" : "");
      for (int round = 0; round < 3; ++round) {
        ExpectSame(TracePackets(little, rays, query, 1, nullptr), expected, what + ", little");
        for (const uint32_t lanes : {3u, 4u, 7u, 8u, 13u, 16u}) {
          ExpectSame(TracePackets(scene, rays, query, lanes, nullptr), expected,
                     what + ", packets of " + std::to_string(lanes));
        }
        for (const std::size_t count : {2u, 7u, 33u, 64u, 65u, 200u, 600u}) {
          ExpectSame(TraceInCalls(scene, rays, query, count), expected,
                     what + ", by " + std::to_string(count));
        }
        if (HasFatalFailure()) return;
      }
    }
  }
}

// Around the number of rays at which calls take another way, and far beyond.
TEST_P(KeptTraceTest, TheNumberOfRaysACallDoesNotChangeABit) {
  Random random(3);
  const auto rays = MakeFullRays(random, 600);
  const WorldScene world(WithBudget(kDefaultBudget, 2), {});
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const auto expected = TraceForm(*world.scene, rays, query);
    for (const std::size_t count :
         {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{17}, policy::kShortCall - 1,
          policy::kShortCall, policy::kShortCall + 1}) {
      ExpectSame(TraceInCalls(*world.scene, rays, query, count), expected,
                 std::to_string(count) + " rays a call");
      if (HasFatalFailure()) return;
    }
  }
}

// What a callback sees by another width is the same.
TEST_P(KeptTraceTest, CallbacksOfEveryWidth) {
  Random random(4);
  const auto rays = MakeFullRays(random, 500);
  const WorldScene world(WithBudget(kDefaultBudget), {});
  for (const Query query : {Query::kClosest, Query::kAny}) {
    const auto expected = TraceForm(*world.scene, rays, query);
    for (const uint32_t width : {1u, 3u, 4u, 8u}) {
      ExpectSame(TraceForm(*world.scene, rays, query, kRecords, {width, nullptr}), expected,
                 "width " + std::to_string(width));
    }
  }
}

TEST_P(KeptTraceTest, PacketsWithoutMasksMeetEverything) {
  Random random(5);
  const auto rays = MakeFullRays(random, 300);
  auto full = rays;
  for (FullRay& ray : full) ray.Set(kMask, UINT32_MAX);
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    const WorldScene world(WithBudget(budget), {});
    for (const Query query : {Query::kClosest, Query::kAny}) {
      auto expected = TraceForm(*world.scene, full, query);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        expected[i].Set(kMask, rays[i].Get<uint32_t>(kMask));
      }
      for (const uint32_t lanes : {1u, 4u, 16u}) {
        ExpectSame(TracePackets(*world.scene, rays, query, lanes, nullptr, false), expected,
                   std::to_string(lanes) + " lanes");
      }
    }
  }
}

// A hit writes the caller's value for rays outside of instances, by whatever way.
TEST_P(KeptTraceTest, InstanceValues) {
  Mesh mesh;
  mesh.Add({1, -1, -1}, {1, 1, -1}, {1, 0, 1});
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    const auto scene = MakeScene(mesh, WithBudget(budget));
    for (const uint32_t lanes : {1u, 4u, 16u}) {
      const std::vector<FullRay> rays(lanes, FullRayOf(MakeRay({0, 0, 0}, {1, 0, 0})));
      FormedRays formed(rays, {lanes, false, false});
      RayPacket packet;
      packet.values = reinterpret_cast<void*>(formed.View().org_x);
      packet.lanes = lanes;
      packet.instance_value = 1234;
      scene->Trace(Query::kClosest, packet);
      for (const FullRay& ray : formed.Rays()) EXPECT_EQ(ray.Get<uint32_t>(kInstanceId), 1234u);
    }
  }
}

// Two hits of one leaf that are so close together that the depth test passes both, the nearer one
// in the first vector of the leaf and the other in the second one, where vectors are short. The
// first ray fills in the leaf.
TEST_P(KeptTraceTest, OneRayKeepsTheNearerOfTwoVectorsOfALeaf) {
  Mesh mesh;
  const float near = 1, behind = 1 + 0x3p-23f;
  mesh.Add({near, -1, -1}, {near, 2, -1}, {near, -1, 2});
  for (int i = 0; i < 3; ++i) mesh.Add({5, 8, 8}, {5, 9, 8}, {5, 8, 9});
  mesh.Add({behind, -2, -3}, {behind, 4, -1}, {behind, -1, 5});
  for (int i = 0; i < 3; ++i) mesh.Add({6, 8, 8}, {6, 9, 8}, {6, 8, 9});
  const auto scene = MakeScene(mesh, WithBudget(uint64_t{1} << 20));
  const FullRay before = FullRayOf(MakeRay({0, 0, 0}, {1, 0, 0}));
  for (int round = 0; round < 3; ++round) {
    FormedRays formed({before}, {1, false, false});
    RayPacket packet;
    packet.values = reinterpret_cast<void*>(formed.View().org_x);
    scene->Trace(Query::kClosest, packet);
    const FullRay after = formed.Rays()[0];
    EXPECT_EQ(after.Get<uint32_t>(kPrimitiveId), 0u);
    EXPECT_EQ(after.Get(kTfar), near);
    EXPECT_EQ(std::abs(after.Get(kNgX)), 9) << "of the nearer triangle";
  }
}

TEST_P(KeptTraceTest, PacketsOfWrongWidthsAreRefused) {
  const auto scene = MakeScene(Mesh(), WithBudget(kDefaultBudget));
  std::vector<float> values(kPacketComponents * 17);
  for (const uint32_t lanes : {0u, 17u}) {
    RayPacket packet;
    packet.values = values.data();
    packet.lanes = lanes;
    EXPECT_THROW(scene->Trace(Query::kClosest, packet), std::invalid_argument);
    EXPECT_THROW(scene->Trace(Query::kAny, packet), std::invalid_argument);
  }
}

// Threads that come to a fresh scene at once, by every way in: they split its subsets and fill in
// its leaves side by side.
TEST_P(KeptTraceTest, ThreadsByEveryWayIn) {
  Random random(6);
  const auto rays = MakeFullRays(random, 300);
  for (const bool has_callbacks : {false, true}) {
    WorldScene::Options options;
    options.has_callbacks = has_callbacks;
    const WorldScene pure(WithBudget(0), options);
    const auto expected = TraceForm(*pure.scene, rays, Query::kClosest);
    const auto expected_any = TraceForm(*pure.scene, rays, Query::kAny);
    for (const uint64_t budget : {uint64_t{1}, uint64_t{20000}, kDefaultBudget}) {
      for (int round = 0; round < 2; ++round) {
        const WorldScene world(WithBudget(budget, 2), options);
        const Scene& scene = *world.scene;
        std::vector<std::vector<FullRay>> found(5);
        std::vector<std::thread> threads;
        threads.emplace_back(
            [&] { found[0] = TracePackets(scene, rays, Query::kClosest, 1, nullptr); });
        threads.emplace_back(
            [&] { found[1] = TracePackets(scene, rays, Query::kClosest, 8, nullptr); });
        threads.emplace_back([&] { found[2] = TraceInCalls(scene, rays, Query::kAny, 200); });
        threads.emplace_back([&] { found[3] = TraceForm(scene, rays, Query::kClosest); });
        threads.emplace_back(
            [&] { found[4] = TracePackets(scene, rays, Query::kAny, 16, nullptr); });
        for (std::thread& thread : threads) thread.join();
        for (std::size_t i = 0; i < found.size(); ++i) {
          ExpectSame(found[i], i % 2 == 0 && i > 0 ? expected_any : expected,
                     "thread " + std::to_string(i) + ", budget " + std::to_string(budget));
        }
        if (HasFatalFailure()) return;
      }
    }
  }
}

// A filter function that traces rays of its own through the same fresh scene, which has subsets to
// split and leaves to fill in on the way. It is asked on the way, or last.
TEST_P(KeptTraceTest, CallbacksMayTraceTheSameScene) {
  Random random(10);
  const Mesh mesh = MakeSoup(random, 6000, 1, 0.1f);
  struct Inner {
    const Scene* scene = nullptr;
    std::vector<FullRay> rays, expected;
    std::size_t calls = 0, wrong = 0;
    bool is_inside = false;

    static void Filter(void* data, const CallbackArguments&) {
      auto& self = *static_cast<Inner*>(data);
      if (self.is_inside || self.calls >= 60) return;
      self.is_inside = true;
      ++self.calls;
      const auto found = self.calls % 2 == 0
                             ? TracePackets(*self.scene, self.rays, Query::kClosest, 8, nullptr)
                             : TraceForm(*self.scene, self.rays, Query::kClosest);
      self.wrong += found != self.expected;
      self.is_inside = false;
    }
  };
  const auto rays = MakeFullRays(random, 700);
  const std::vector<FullRay> few(rays.begin(), rays.begin() + 40);
  std::vector<FullRay> expected;
  const auto test = [&](uint64_t budget, bool is_short, bool at_once) {
    Inner inner;
    Geometry geometry;
    geometry.vertices = {{mesh.vertices.data(), 12}};
    geometry.vertex_count = mesh.vertices.size();
    geometry.primitives = {mesh.triangles.data(), 12};
    geometry.primitive_count = mesh.triangles.size();
    geometry.closest_filter = {Inner::Filter, &inner};
    std::vector<Geometry> geometries = {geometry};
    if (at_once) geometries.push_back(unit::UserGeometry(1));
    const Scene scene(std::make_shared<Device>(WithBudget(budget)), geometries, SceneOptions{});
    if (expected.empty()) {
      inner.calls = 1000;
      expected = TraceForm(scene, rays, Query::kClosest);
      inner.calls = 0;
    }
    inner.scene = &scene;
    inner.rays = few;
    inner.expected = {expected.begin(), expected.begin() + 40};
    ExpectSame(is_short ? TraceInCalls(scene, rays, Query::kClosest, 100)
                        : TraceForm(scene, rays, Query::kClosest),
               expected, "budget " + std::to_string(budget));
    EXPECT_GT(inner.calls, at_once ? 10u : 3u);
    EXPECT_EQ(inner.wrong, 0u) << "budget " << budget;
  };
  for (const uint64_t budget : {uint64_t{0}, uint64_t{1}, uint64_t{60000}, kDefaultBudget}) {
    for (const bool is_short : {false, true}) {
      for (const bool at_once : {true, false}) test(budget, is_short, at_once);
    }
  }
}

TEST_P(KeptTraceTest, BudgetsAreKept) {
  Random random(11);
  constexpr std::size_t kTriangles = 30000;
  const Mesh mesh = MakeSoup(random, kTriangles, 1, 0.03f);
  const TriangleMesh view = mesh.View();
  auto rays = MakeRays(random, 40000, 1);
  const std::size_t least = KeptPartition::LeastBytes(kTriangles);
  struct Case {
    uint64_t budget;
    Keep keep;
    std::size_t most;
  };
  const std::size_t by_default = 64 * kTriangles + 48 * 16384 + 64 * 1024;
  const Case cases[] = {{kDefaultBudget, Keep::kByBudget, by_default},
                        {kDefaultBudget, Keep::kLittle, 8 * kTriangles},
                        {kUnlimitedBudget, Keep::kLittle, 8 * kTriangles},
                        {500000, Keep::kByBudget, 500000},
                        {200000, Keep::kLittle, 200000},
                        {1, Keep::kByBudget, least},
                        {1, Keep::kLittle, least}};
  for (const Case& c : cases) {
    const Scene scene(std::make_shared<Device>(WithBudget(c.budget)), {&view, 1}, c.keep);
    EXPECT_LE(scene.KeptBytes(), c.most);
    EXPECT_GT(scene.KeptBytes(), 0u);
    auto copy = rays;
    scene.Trace(Query::kClosest, ViewOf(copy));
    EXPECT_LE(scene.KeptBytesUsed(), scene.KeptBytes());
  }
  const Scene nothing(std::make_shared<Device>(WithBudget(0)), {&view, 1}, Keep::kLittle);
  EXPECT_EQ(nothing.KeptBytes(), 0u);
}

}  // namespace
}  // namespace dacrt::unit
