// Scene::Trace over deep and degenerate partitions, beside brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "kept_trace.h"

namespace dacrt::unit {
namespace {

using enum PacketComponent;

class DegenerateTraceTest : public KeptTraceTest {};

INSTANTIATE_ON_EACH_INSTRUCTION_SET(DegenerateTraceTest);

/// Rays against triangles one by one, each a scene of its own: of those at equal distances the one
/// with the smallest name counts.
std::vector<FullRay> ByBruteForce(const Mesh& mesh, const std::vector<FullRay>& rays,
                                  const Settings& settings) {
  std::vector<FullRay> nearest = rays;
  const auto device = std::make_shared<Device>(settings);
  for (uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    Mesh one;
    one.geometry_id = mesh.geometry_id;
    one.Add(mesh.Corner(triangle, 0), mesh.Corner(triangle, 1), mesh.Corner(triangle, 2));
    const TriangleMesh view = one.View();
    const Scene scene(device, {&view, 1});
    // What was found so far ends the ray, and a hit at just that distance does not count.
    auto found = TraceForm(scene, rays, Query::kClosest);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!found[i].IsHit() || !(found[i].Get(kTfar) < nearest[i].Get(kTfar))) continue;
      nearest[i] = found[i];
      nearest[i].Set(kPrimitiveId, triangle);
    }
  }
  return nearest;
}

void ExpectBruteForce(const Mesh& mesh, const std::vector<FullRay>& rays, const Settings& base,
                      const std::string& what) {
  Settings settings = base;
  settings.budget = 0;
  const auto expected = ByBruteForce(mesh, rays, settings);
  EXPECT_GT(std::count_if(expected.begin(), expected.end(),
                          [](const FullRay& ray) { return ray.IsHit(); }),
            static_cast<std::ptrdiff_t>(rays.size() / 20))
      << what;
  const TriangleMesh view = mesh.View();
  for (const uint64_t budget : {uint64_t{0}, uint64_t{1}, uint64_t{20000}, kUnlimitedBudget}) {
    settings.budget = budget;
    const Scene scene(std::make_shared<Device>(settings), {&view, 1});
    const std::string where = what + ", budget " + std::to_string(budget);
    ExpectSame(TraceForm(scene, rays, Query::kClosest), expected, where);
    ExpectSame(TraceInCalls(scene, rays, Query::kClosest, 100), expected, where + ", by 100");
    ExpectSame(TracePackets(scene, rays, Query::kClosest, 1, nullptr), expected,
               where + ", singles");
    ExpectSame(TracePackets(scene, rays, Query::kClosest, 16, nullptr), expected,
               where + ", packets");
    auto blocked = rays;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (expected[i].IsHit()) blocked[i].Set(kTfar, -kInfinity);
    }
    ExpectSame(TraceForm(scene, rays, Query::kAny), blocked, where + ", any");
    ExpectSame(TracePackets(scene, rays, Query::kAny, 1, nullptr), blocked, where + ", any");
    if (testing::Test::HasFatalFailure()) return;
  }
}

std::vector<FullRay> Bundle(Random& random, std::size_t count, const Float3& org, float spread) {
  std::vector<FullRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Float3 dir = {1, random.Uniform(-spread, spread), random.Uniform(-spread, spread)};
    if (i % 2 == 1) {
      for (float& x : dir) x = std::abs(x);  // many of one octant
    }
    rays.push_back(FullRayOf(MakeRay(org, dir)));
  }
  return rays;
}

// Sizes and distances in a geometric series: nodes peel off a few triangles at a time, and a ray
// from the middle enters every one of them.
TEST_P(DegenerateTraceTest, ExponentialSeries) {
  Random random(7);
  for (const int a_power : {1, 7, 16}) {
    Mesh mesh;
    for (int exponent = -40; exponent < 40; ++exponent) {
      for (int i = 0; i < a_power; ++i) {
        const float s = std::exp2(static_cast<float>(exponent) +
                                  static_cast<float>(i) / static_cast<float>(a_power));
        // A strip of the square across the x axis that only some rays meet.
        const float begin = random.Uniform(-1, 0.9f), end = begin + 0.1f;
        mesh.Add({s, begin * s, -s}, {s, end * s, -s}, {s, end * s, s});
      }
    }
    ExpectBruteForce(mesh, Bundle(random, 300, {0, 0, 0}, 1), WithBudget(0),
                     std::to_string(a_power) + " a power of two");
    if (HasFatalFailure()) return;
  }
}

// More than a leaf, a node and a subset hold.
TEST_P(DegenerateTraceTest, TrianglesThatCoincide) {
  Random random(8);
  Mesh mesh;
  for (int i = 0; i < 40; ++i) {
    const Float3 a = random.InCube(-1, 1), b = random.InCube(-1, 1), c = random.InCube(-1, 1);
    for (int copy = 0; copy < 1 + i % 12; ++copy) mesh.Add(a, b, c);
  }
  std::vector<FullRay> rays;
  for (int i = 0; i < 300; ++i) {
    rays.push_back(FullRayOf(MakeRay(random.InCube(-2, 2), random.Direction())));
  }
  ExpectBruteForce(mesh, rays, WithBudget(0), "copies");
}

// Large numbers of them: the smallest name, whatever stands where in the order. Where the ray
// begins there is no slack that would open a box before the hits in it.
TEST_P(DegenerateTraceTest, ThousandsThatCoincide) {
  Mesh mesh;
  mesh.vertices = {{1, -1, -1}, {1, 1, -1}, {1, 0, 1}};
  mesh.triangles.assign(5000, {0, 1, 2});
  for (const float distance : {1.0f, 0.0f}) {
    const std::vector<FullRay> rays(60, FullRayOf(MakeRay({1 - distance, 0, 0}, {1, 0, 0}, -1)));
    for (const uint64_t budget : {uint64_t{1}, uint64_t{8 * 5000}, kUnlimitedBudget}) {
      const auto scene = MakeScene(mesh, WithBudget(budget));
      for (const auto& found : {TraceForm(*scene, rays, Query::kClosest),
                                TraceInCalls(*scene, rays, Query::kClosest, 50),
                                TracePackets(*scene, {rays[0]}, Query::kClosest, 1, nullptr),
                                TracePackets(*scene, rays, Query::kClosest, 16, nullptr)}) {
        for (const FullRay& ray : found) {
          ASSERT_EQ(ray.Get(kTfar), distance);
          ASSERT_EQ(ray.Get<uint32_t>(kPrimitiveId), 0u);
        }
      }
    }
  }
}

// Many that overlap in one plane and are numbered against their order in space: the smallest name
// stands anywhere in its leaf. The rays run in no order, so that they go by lists.
TEST_P(DegenerateTraceTest, TrianglesThatOverlapInOnePlane) {
  Random random(10);
  Mesh mesh;
  constexpr int kCount = 600;
  for (int i = 0; i < kCount; ++i) {
    const float y = 1 - 2 * static_cast<float>(i) / kCount;
    mesh.Add({1, y - 0.1f, -1}, {1, y + 0.1f, -1}, {1, y, 1});
  }
  std::vector<FullRay> rays;
  for (int i = 0; i < 300; ++i) {
    rays.push_back(
        FullRayOf(MakeRay({-1, random.Uniform(-1, 1), random.Uniform(-1, 1)}, {1, 0, 0})));
  }
  ExpectBruteForce(mesh, rays, WithBudget(0), "in one plane");
}

// Hits so near that the distance has lost most of its bits: rounded down it is less than where the
// ray meets the others. Between two heaps that are as large, so that triangles change places.
TEST_P(DegenerateTraceTest, TrianglesThatCoincideAtDenormalDistances) {
  Mesh mesh;
  for (int i = 0; i < 300; ++i) {
    const float x = i % 2 == 0 ? 100 : -100;
    mesh.Add({0, 0, 0}, {-0x1.0ad906p+2f, 0x1.5p-145f, 0},
             {0x1.6af9acp+45f, 0x1.a78634p-111f, -0x1.79f1fap+54f});
    mesh.Add({x, x, x}, {x + 1, x, x}, {x, x + 1, x});
  }
  const std::vector<FullRay> rays(60,
                                  FullRayOf(MakeRay({-0x1.08p+2f, 0, -16}, {0, 0x1.dp-2f, 1}, 0)));
  for (const uint64_t budget : {uint64_t{0}, uint64_t{1}, kUnlimitedBudget}) {
    const auto scene = MakeScene(mesh, WithBudget(budget));
    for (const auto& found : {TraceForm(*scene, rays, Query::kClosest),
                              TracePackets(*scene, {rays[0]}, Query::kClosest, 1, nullptr),
                              TracePackets(*scene, rays, Query::kClosest, 16, nullptr)}) {
      for (const FullRay& ray : found) {
        ASSERT_EQ(ray.Get(kTfar), 0x1.7p-144f) << "budget " << budget;
        ASSERT_EQ(ray.Get<uint32_t>(kPrimitiveId), 0u) << "budget " << budget;
      }
    }
  }
}

// Slivers and points, all through one point.
TEST_P(DegenerateTraceTest, SliversThroughOnePoint) {
  Random random(9);
  Mesh mesh;
  for (int i = 0; i < 600; ++i) {
    const Float3 d = random.Direction(), e = random.Direction();
    const float thin = std::exp2(random.Uniform(-20, -3));
    mesh.Add({-d[0], -d[1], -d[2]}, {d[0], d[1], d[2]},
             {d[0] + thin * e[0], d[1] + thin * e[1], d[2] + thin * e[2]});
    if (i % 10 == 0) mesh.Add(d, d, d);
  }
  std::vector<FullRay> rays;
  for (int i = 0; i < 300; ++i) {
    rays.push_back(FullRayOf(MakeRay(random.InCube(-1, 1), random.Direction())));
  }
  ExpectBruteForce(mesh, rays, WithBudget(0), "slivers");
}

}  // namespace
}  // namespace dacrt::unit
