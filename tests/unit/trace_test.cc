// Scene::Trace through the public API: right, the same whatever the settings, and bounded.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <thread>

#include "dacrt/dacrt.h"
#include "partition/kept_partition.h"
#include "trace/policy.h"
#include "trace_scene.h"

namespace dacrt::unit {
namespace {

INSTANTIATE_ON_EACH_INSTRUCTION_SET(TraceTest);

// Against brute force in double precision: what is hit without doubt is found, what is reported is
// a hit, and nothing clearly nearer exists.
TEST_P(TraceTest, FindsWhatBruteForceFinds) {
  Random random(1);
  for (const Settings& varied : {VariedSettings()[0], VariedSettings()[16], VariedSettings()[17],
                                 VariedSettings().back(), Settings()}) {
    Mesh mesh = MakeSoup(random, 500, 2, 0.5f);
    mesh.geometry_id = 3;
    const TestScene scene({mesh}, WithInstructionSet(varied));
    const auto before = MakeMixedRays(random, 600);
    const auto after = scene.Traced(before);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      const Ray& ray = before[i];
      if (ray.tnear > ray.tfar || ray.tfar < 0) {
        ASSERT_TRUE(SameBits(after[i], ray)) << "inactive";
        continue;
      }
      // The nearest of the triangles that are hit without doubt.
      constexpr double kClear = 1e-3;
      double nearest = kInfinity;
      for (std::size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
        const ExactHit exact = IntersectExactly(ray, mesh, triangle);
        if (exact.inside < kClear || exact.t < std::max(0.0, ray.tnear + kClear) ||
            exact.t > ray.tfar - kClear) {
          continue;
        }
        nearest = std::min(nearest, exact.t);
      }
      ASSERT_LE(after[i].tfar, nearest * (1 + kClear)) << "ray " << i;
      if (!after[i].IsHit()) {
        ASSERT_TRUE(SameBits(after[i], ray)) << "a miss leaves every byte";
        continue;
      }
      ++hits;
      ASSERT_EQ(after[i].geometry_id, 3u);
      ASSERT_LT(after[i].primitive_id, mesh.triangles.size());
      const ExactHit exact = IntersectExactly(ray, mesh, after[i].primitive_id);
      ASSERT_GT(exact.inside, -kClear) << "ray " << i;
      ASSERT_NEAR(after[i].u, exact.u, kClear);
      ASSERT_NEAR(after[i].v, exact.v, kClear);
      ASSERT_NEAR(after[i].tfar, exact.t, kClear * std::max(1.0, exact.t));
      ASSERT_LE(after[i].tfar, ray.tfar);
    }
    EXPECT_GT(hits, 150u);
    ExpectBlockedWhereHit(scene.Traced(before, Query::kAny), before, after);
  }
}

// "The same rays get the same bits whatever the settings, the pieces and the other rays in the
// batch."
TEST_P(TraceTest, SettingsDoNotChangeABit) {
  Random random(2);
  const auto meshes = MakeMeshes(random);
  // From everywhere; from one point in all directions; from one point in order, as a camera does
  // it.
  auto from_a_point = MakeMixedRays(random, 1500);
  for (Ray& ray : from_a_point) ray.org = {0.3f, -0.2f, 0.1f};
  auto camera = MakeMixedRays(random, 1500);
  for (std::size_t i = 0; i < camera.size(); ++i) AimAsACamera(camera[i], i);
  auto fine_camera = MakeMixedRays(random, 1500);
  for (std::size_t i = 0; i < camera.size(); ++i) AimAsAFineCamera(fine_camera[i], i);
  for (const auto& before : {MakeMixedRays(random, 1500), from_a_point, camera, fine_camera}) {
    const auto expected = TestScene(meshes, WithInstructionSet()).Traced(before);
    const std::vector<Settings> all = VariedSettings();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const TestScene scene(meshes, WithInstructionSet(all[i]));
      ExpectSameRays(scene.Traced(before), expected, "settings " + std::to_string(i));
      ExpectBlockedWhereHit(scene.Traced(before, Query::kAny), before, expected);
      if (HasFatalFailure()) return;
    }
  }
}

// Else the test above would not say anything about conic packets.
TEST_P(TraceTest, RaysOfACameraAreFilteredInPackets) {
  Random random(17);
  Settings settings;
  settings.algorithm = Algorithm::kMora2011;
  const TestScene scene(MakeMeshes(random), WithInstructionSet(settings));
  std::vector<Ray> rays(1500);
  for (std::size_t i = 0; i < rays.size(); ++i) AimAsACamera(rays[i], i);
  EXPECT_GT(scene.Trace(rays).packet_tests, 0u);
  rays = MakeRays(random, 1500, 3);
  EXPECT_EQ(scene.Trace(rays).packet_tests, 0u);
}

// Nor do the budget, the threads and the pieces, nor what earlier calls have split.
TEST_P(TraceTest, KeptPartitionsDoNotChangeABit) {
  Random random(19);
  const auto large = MakeLargeMeshes(random);
  const std::size_t triangles = large[0].triangles.size() + large[1].triangles.size();
  auto camera = MakeMixedRays(random, 2500);
  for (std::size_t i = 0; i < camera.size(); ++i) AimAsAFineCamera(camera[i], i);
  const std::vector<std::vector<Ray>> batches = {MakeMixedRays(random, 2500), camera};
  Settings nothing;
  nothing.budget = 0;
  const TestScene pure(large, WithInstructionSet(nothing));
  ASSERT_EQ((*pure).KeptBytes(), 0u);
  std::vector<std::vector<Ray>> expected;
  for (const auto& batch : batches) {
    expected.push_back(pure.Traced(batch));
    ExpectBlockedWhereHit(pure.Traced(batch, Query::kAny), batch, expected.back());
  }
  for (const uint64_t budget : VariedBudgets(triangles)) {
    for (const uint32_t threads : {1u, 8u}) {
      for (const uint32_t piece_rays : {64u, Settings().piece_rays}) {
        Settings settings;
        settings.budget = budget;
        settings.threads = threads;
        settings.piece_rays = piece_rays;
        const std::string what = "budget " + std::to_string(budget) + ", threads " +
                                 std::to_string(threads) + ", pieces " + std::to_string(piece_rays);
        SCOPED_TRACE(what);
        // One scene begins with each kind of batch, and with each query.
        for (std::size_t first = 0; first < 2; ++first) {
          const TestScene scene(large, WithInstructionSet(settings));
          ASSERT_GT((*scene).KeptBytes(), 0u);
          for (int call = 0; call < 3; ++call) {
            const std::size_t kind = (first + static_cast<std::size_t>(call)) % 2;
            if ((call + static_cast<int>(first)) % 3 == 1) {
              ExpectBlockedWhereHit(scene.Traced(batches[kind], Query::kAny), batches[kind],
                                    expected[kind]);
            } else {
              ExpectSameRays(scene.Traced(batches[kind]), expected[kind],
                             "call " + std::to_string(call));
            }
            if (HasFatalFailure()) return;
          }
          ASSERT_LE((*scene).KeptBytesUsed(), (*scene).KeptBytes());
        }
      }
    }
  }
}

TEST_P(TraceTest, OtherRaysOfTheBatchDoNotChangeABit) {
  Random random(3);
  const TestScene scene(MakeMeshes(random), WithInstructionSet());
  const auto before = MakeMixedRays(random, 2000);
  const auto expected = scene.Traced(before);
  std::vector<std::size_t> order(before.size());
  std::iota(order.begin(), order.end(), 0);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = order.size(); i > 1; --i) {
      std::swap(order[i - 1], order[random.Below(static_cast<uint32_t>(i))]);
    }
    // All in another order, then ever fewer.
    for (std::size_t count = before.size(); count > 0; count /= 7) {
      std::vector<Ray> rays, rays_expected;
      for (std::size_t i = 0; i < count; ++i) {
        rays.push_back(before[order[i]]);
        rays_expected.push_back(expected[order[i]]);
      }
      ExpectSameRays(scene.Traced(rays), rays_expected, std::to_string(count) + " rays");
    }
  }
}

// Where distances are equal the smallest (geometry_id, primitive_id) is reported, not the one that
// the partition happens to meet first.
TEST_P(TraceTest, CoincidentTrianglesGiveTheSmallestName) {
  Random random(4);
  Mesh soup = MakeSoup(random, 200, 2, 0.5f), doubled;
  for (std::size_t i = 200; i > 0; --i) {
    doubled.Add(soup.Corner(i - 1, 0), soup.Corner(i - 1, 1), soup.Corner(i - 1, 2));
  }
  soup.geometry_id = 8;
  doubled.geometry_id = 4;
  const auto before = MakeRays(random, 500, 3);
  const TestScene both({soup, doubled}, WithInstructionSet());
  const TestScene one({doubled}, WithInstructionSet());
  ExpectSameRays(both.Traced(before), one.Traced(before), "the later mesh");
}

// Scenes whose size, place and shape strain single precision: far from the origin, tiny, huge,
// flat.
TEST_P(TraceTest, SettingsDoNotChangeABitInScenesOfAnyScale) {
  Random random(5);
  struct Scale {
    float size, offset, flatness;
  };
  const Scale scales[] = {{1, 1000, 1},    {1, 1e6f, 1},     {1e-6f, 0, 1}, {1e-19f, 0, 1},
                          {1e-25f, 0, 1},  {1e6f, 0, 1},     {1e17f, 0, 1}, {1, 0, 1e-6f},
                          {1, 100, 1e-5f}, {1, 3, 0x1p-20f}, {1, 0, 0}};
  for (const Scale& scale : scales) {
    const auto place = [&](Float3 p) {
      p[1] *= scale.flatness;
      for (float& x : p) x = x * scale.size + scale.offset;
      return p;
    };
    std::vector<Mesh> meshes = {MakeSoup(random, 400, 1, 0.5f)};
    for (Float3& vertex : meshes[0].vertices) vertex = place(vertex);
    std::vector<Ray> rays;
    for (int i = 0; i < 600; ++i) {
      const Float3 org = place(random.InCube(-2, 2)), target = place(random.InCube(-1, 1));
      rays.push_back(MakeRay(org, {target[0] - org[0], target[1] - org[1], target[2] - org[2]}));
      if (i % 3 == 0) rays.back().tfar = random.Uniform(0.5f, 1.5f);
    }
    const auto expected = TestScene(meshes, WithInstructionSet()).Traced(rays);
    for (const Settings& settings : VariedSettings()) {
      const TestScene scene(meshes, WithInstructionSet(settings));
      const std::string what = "size " + std::to_string(scale.size) + " offset " +
                               std::to_string(scale.offset) + " flatness " +
                               std::to_string(scale.flatness);
      ExpectSameRays(scene.Traced(rays), expected, what);
      ExpectBlockedWhereHit(scene.Traced(rays, Query::kAny), rays, expected);
      if (HasFatalFailure()) return;
    }
  }
}

TEST_P(TraceTest, RayMasks) {
  Random random(6);
  std::vector<Mesh> meshes;
  for (uint32_t id = 0; id < 4; ++id) {
    meshes.push_back(MakeSoup(random, 150, 2, 0.8f));
    meshes.back().geometry_id = id;
    meshes.back().mask = id == 3 ? 0 : 1u << id;
  }
  const TestScene all(meshes, WithInstructionSet());
  auto before = MakeRays(random, 800, 3);
  for (Ray& ray : before) ray.mask = random.Below(8);
  const auto after = all.Traced(before);
  // A scene of the meshes that a mask lets through gives the same answer.
  for (uint32_t mask = 0; mask < 8; ++mask) {
    std::vector<Mesh> allowed;
    for (const Mesh& mesh : meshes) {
      if (mesh.mask & mask) allowed.push_back(mesh);
    }
    for (Mesh& mesh : allowed) mesh.mask = UINT32_MAX;
    const TestScene some(allowed, WithInstructionSet());
    std::vector<Ray> rays, expected;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i].mask != mask) continue;
      rays.push_back(before[i]);
      expected.push_back(after[i]);
    }
    ExpectSameRays(some.Traced(rays), expected, "mask " + std::to_string(mask));
  }
  ExpectBlockedWhereHit(all.Traced(before, Query::kAny), before, after);
}

TEST_P(TraceTest, InstanceValueIsWrittenOnHits) {
  Random random(7);
  const TestScene scene(MakeMeshes(random), WithInstructionSet());
  auto rays = MakeMixedRays(random, 100);
  for (Ray& ray : rays) ray.instance_id = 1;
  RayView view = ViewOf(rays);
  view.instance_value = 1234;
  (*scene).Trace(Query::kClosest, view);
  for (const Ray& ray : rays) EXPECT_EQ(ray.instance_id, ray.IsHit() ? 1234u : 1u);
}

TEST_P(TraceTest, RaysThatAreNotNumbersHarmNoOther) {
  Random random(8);
  const TestScene scene(MakeMeshes(random), WithInstructionSet());
  const auto good = MakeRays(random, 400, 3);
  const auto expected = scene.Traced(good);
  auto mixed = good;
  const float bad[] = {kNaN, kInfinity, -kInfinity};
  for (std::size_t i = 0; i < mixed.size(); i += 3) {
    switch (random.Below(4)) {
      case 0:
        mixed[i].org[random.Below(3)] = bad[random.Below(3)];
        break;
      case 1:
        mixed[i].dir[random.Below(3)] = bad[random.Below(3)];
        break;
      case 2:
        mixed[i].tnear = kNaN;
        break;
      default:
        mixed[i].tfar = kNaN;
        break;
    }
  }
  const auto before = mixed;
  scene.Trace(mixed);
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    ASSERT_TRUE(SameBits(mixed[i], i % 3 == 0 ? before[i] : expected[i])) << "ray " << i;
  }
}

TEST_P(TraceTest, StatisticsAddUp) {
  Random random(9);
  for (Settings settings : VariedSettings()) {
    if (settings.budget > 0) continue;
    if (settings.piece_rays > 1000) settings.piece_rays = 1000;
    const TestScene scene(MakeMeshes(random), WithInstructionSet(settings));
    auto rays = MakeMixedRays(random, 2500);
    std::size_t active = 0, hits = 0;
    for (const Ray& ray : rays) active += ray.tnear <= ray.tfar && ray.tfar >= 0;
    const Statistics statistics = scene.Trace(rays);
    for (const Ray& ray : rays) hits += ray.IsHit();
    EXPECT_EQ(statistics.rays, active);
    EXPECT_EQ(statistics.hits, hits);
    EXPECT_EQ(statistics.pieces, (2500 + settings.piece_rays - 1) / settings.piece_rays);
    EXPECT_GE(statistics.max_depth, 1u);
    EXPECT_GT(statistics.direct_solves, 0u);
    EXPECT_GE(statistics.subproblems, statistics.direct_solves);
    EXPECT_LE(statistics.rays_filtered, statistics.box_tests);
  }
}

// A kept partition is split once, without sample rays, and no call has splits of its own; pieces
// are counted over all threads.
TEST_P(TraceTest, StatisticsOfAKeptPartitionAddUp) {
  Random random(18);
  for (const uint32_t threads : {1u, 4u}) {
    for (const bool robust : {false, true}) {
      Settings settings;
      settings.threads = threads;
      settings.piece_rays = 1000;
      const std::vector<Mesh> meshes = MakeMeshes(random);
      std::vector<Geometry> geometries;
      for (const Mesh& mesh : meshes) geometries.push_back(GeometryOf(mesh));
      const Scene scene(std::make_shared<Device>(WithInstructionSet(settings)), geometries,
                        SceneOptions{Keep::kByBudget, robust});
      for (const Query query : {Query::kClosest, Query::kAny}) {
        auto rays = MakeMixedRays(random, 2500);
        std::size_t active = 0, hits = 0;
        for (const Ray& ray : rays) active += ray.tnear <= ray.tfar && ray.tfar >= 0;
        // On a thread that has learnt nothing from other tests.
        Statistics statistics;
        std::thread([&] { statistics = scene.Trace(query, ViewOf(rays)); }).join();
        for (const Ray& ray : rays) {
          hits += query == Query::kAny ? ray.tfar == -kInfinity : ray.IsHit();
        }
        EXPECT_EQ(statistics.rays, active);
        EXPECT_EQ(statistics.hits, hits);
        // On several threads the last pieces are smaller.
        if (threads == 1) {
          EXPECT_EQ(statistics.pieces, 3u);
        }
        EXPECT_GE(statistics.pieces, 3u);
        // Other threads may have learnt that groups are quicker, which count less; robust rays
        // apart go by lists in any case.
        if (threads == 1 || robust) {
          EXPECT_GT(statistics.subproblems, 0u);
          EXPECT_GT(statistics.box_tests, 0u);
          EXPECT_GT(statistics.direct_solves, 0u);
        }
        EXPECT_GE(statistics.direct_rays, statistics.direct_solves);
        EXPECT_EQ(statistics.sampled_splits + statistics.sah_splits + statistics.median_splits, 0u);
      }
    }
  }
}

// Calls of few rays go a way on which nothing is counted.
TEST_P(TraceTest, ShortCallsCountNothing) {
  Random random(22);
  const TestScene scene(MakeMeshes(random), WithInstructionSet());
  for (const std::size_t count : {std::size_t{1}, std::size_t{64}, policy::kShortCall}) {
    auto rays = MakeRays(random, count, 3);
    const Statistics statistics = scene.Trace(rays);
    EXPECT_EQ(statistics.rays + statistics.hits + statistics.pieces + statistics.subproblems, 0u);
    if (count == policy::kShortCall) {
      EXPECT_GT(std::count_if(rays.begin(), rays.end(), [](const Ray& ray) { return ray.IsHit(); }),
                10);
    }
  }
  auto rays = MakeRays(random, policy::kShortCall + 1, 3);
  EXPECT_EQ(scene.Trace(rays).rays, policy::kShortCall + 1);
}

}  // namespace
}  // namespace dacrt::unit
