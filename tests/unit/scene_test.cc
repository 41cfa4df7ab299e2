#include <gtest/gtest.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "dacrt/dacrt.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::kInfinity;
using unit::kNaN;
using unit::Mesh;
using unit::Random;
using unit::Ray;

TEST(SceneTest, BoundsAndCountAreThoseOfTheTrianglesThatCanBeHit) {
  Mesh mesh;
  mesh.Add({-1, 2, 3}, {4, -5, 6}, {0, 0, -7});
  mesh.Add({1, 1, 1}, {2, 2, 2}, {100, kNaN, 0});
  mesh.Add({1, 1, 1}, {2, 2, 2}, {-2e18f, 0, 0});
  mesh.triangles.push_back({0, 1, 77});
  mesh.vertices.push_back({50, 50, 50});  // of no triangle
  const TriangleMesh view = mesh.View();
  const Scene scene(std::make_shared<Device>(), {&view, 1});
  EXPECT_EQ(scene.triangle_count(), 1u);
  const Bounds bounds = scene.bounds();
  EXPECT_EQ(bounds.lower[0], -1);
  EXPECT_EQ(bounds.lower[1], -5);
  EXPECT_EQ(bounds.lower[2], -7);
  EXPECT_EQ(bounds.upper[0], 4);
  EXPECT_EQ(bounds.upper[1], 2);
  EXPECT_EQ(bounds.upper[2], 6);
}

TEST(SceneTest, WhatIsNotANumberLeavesAPointOut) {
  for (int bad = 0; bad < 7; ++bad) {
    SCOPED_TRACE(bad);
    float points[2][4] = {{1, 2, 3, 0.5f}, {7, 8, 9, 0.5f}};
    float normals[2][3] = {{0, 0, 1}, {0, 0, 1}};
    (bad < 4 ? points[1][bad] : normals[1][bad - 4]) = kNaN;
    Geometry discs;
    discs.shape = Shape::kOrientedDiscs;
    discs.vertices = {{points, sizeof(points[0])}};
    discs.vertex_count = discs.primitive_count = 2;
    discs.normals = {{normals, sizeof(normals[0])}};
    const Scene scene(std::make_shared<Device>(), discs);
    EXPECT_EQ(scene.triangle_count(), 1u);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(scene.bounds().upper[axis], points[0][axis] + 0.5f);
    }
  }
}

TEST(SceneTest, WithoutTrianglesTheBoundsAreEmpty) {
  const Scene scene(std::make_shared<Device>(), {});
  const Bounds bounds = scene.bounds();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(bounds.lower[axis], kInfinity);
    EXPECT_EQ(bounds.upper[axis], -kInfinity);
  }
  EXPECT_EQ(scene.triangle_count(), 0u);
}

TEST(SceneTest, RefusesWhatItCanNotRead) {
  EXPECT_THROW(Scene(nullptr, {}), std::invalid_argument);
  TriangleMesh mesh;
  mesh.triangle_count = 1;
  EXPECT_THROW(Scene(std::make_shared<Device>(), {&mesh, 1}), std::invalid_argument);
}

// Valid triangles at the very ends of their arrays, invalid ones between: none of it is looked at
// where it may not be, in the constructor and in a trace.
TEST(SceneTest, ReadsNothingOutsideTheArrays) {
  unit::GuardedArray<float> vertices(9);
  unit::GuardedArray<uint32_t> triangles(12);
  const float corners[9] = {1, -1, -1, 1, 1, -1, 1, 0, 1};
  const uint32_t indices[12] = {0, 1, 2, 0, 1, 3, UINT32_MAX, 0, 1, 2, 1, 0};
  std::copy(std::begin(corners), std::end(corners), vertices.begin());
  std::copy(std::begin(indices), std::end(indices), triangles.begin());
  TriangleMesh mesh;
  mesh.vertices = vertices.data();
  mesh.vertex_count = 3;
  mesh.triangles = triangles.data();
  mesh.triangle_count = 4;
  const Scene scene(std::make_shared<Device>(), {&mesh, 1});
  EXPECT_EQ(scene.triangle_count(), 2u);
  std::vector<Ray> rays(3, unit::MakeRay({0, 0, 0}, {1, 0, 0}));
  scene.Trace(Query::kClosest, ViewOf(rays));
  for (const Ray& ray : rays) EXPECT_EQ(ray.primitive_id, 0u);
}

// The caller's rays, too: each component in an array that ends at a guard page.
TEST(SceneTest, TouchesNothingOutsideTheRays) {
  Mesh mesh;
  mesh.Add({1, -1, -1}, {1, 1, -1}, {1, 0, 1});
  const TriangleMesh mesh_view = mesh.View();
  const Scene scene(std::make_shared<Device>(), {&mesh_view, 1});
  for (const std::size_t count : {1u, 3u, 16u, 17u, 70u, 256u, 257u, 1100u}) {
    std::vector<std::unique_ptr<unit::GuardedArray<float>>> arrays;
    const auto component = [&](float value) {
      arrays.push_back(std::make_unique<unit::GuardedArray<float>>(count));
      std::fill(arrays.back()->begin(), arrays.back()->end(), value);
      return reinterpret_cast<RayView::Component>(arrays.back()->data());
    };
    RayView view;
    view.count = count;
    view.packet_stride = sizeof(float);
    view.org_x = component(0);
    view.org_y = component(0);
    view.org_z = component(0);
    view.dir_x = component(1);
    view.dir_y = component(0);
    view.dir_z = component(0);
    view.tnear = component(0);
    view.tfar = component(kInfinity);
    view.mask = component(1);
    view.ng_x = component(0);
    view.ng_y = component(0);
    view.ng_z = component(0);
    view.u = component(0);
    view.v = component(0);
    view.primitive_id = component(0);
    view.geometry_id = component(0);
    view.instance_id = component(0);
    scene.Trace(Query::kClosest, view);
    const float* tfar = reinterpret_cast<const float*>(view.tfar);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(tfar[i], 1);
    scene.Trace(Query::kAny, view);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(tfar[i], -kInfinity);
  }
}

TEST(SceneTest, KeepsItsDeviceAlive) {
  Mesh mesh;
  mesh.Add({1, -1, -1}, {1, 1, -1}, {1, 0, 1});
  const TriangleMesh view = mesh.View();
  auto device = std::make_shared<Device>();
  const Scene scene(device, {&view, 1});
  device.reset();
  std::vector<Ray> rays(1, unit::MakeRay({0, 0, 0}, {1, 0, 0}));
  scene.Trace(Query::kClosest, ViewOf(rays));
  EXPECT_TRUE(rays[0].IsHit());
}

TEST(SceneTest, ScenesMayShareADevice) {
  Random random(1);
  const auto device = std::make_shared<Device>();
  const Mesh large = unit::MakeSoup(random, 2000, 1, 0.2f), small = unit::MakeSoup(random, 3, 1, 1);
  const TriangleMesh large_view = large.View(), small_view = small.View();
  const Scene a(device, {&large_view, 1}), b(device, {&small_view, 1});
  auto first = unit::MakeRays(random, 500, 1);
  auto second = first;
  a.Trace(Query::kClosest, ViewOf(first));
  auto other = unit::MakeRays(random, 700, 1);
  b.Trace(Query::kClosest, ViewOf(other));
  a.Trace(Query::kClosest, ViewOf(second));
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(SameBits(first[i], second[i]));
}

// It was divided by zero for.
TEST(SceneTest, ACallWithoutRaysNeedsNoMoreThanOneWithARay) {
  Random random(8);
  const Mesh mesh = unit::MakeSoup(random, 1000, 1, 0.1f);
  const TriangleMesh view = mesh.View();
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    const auto device = std::make_shared<Device>(settings);
    const Scene scene(device, {&view, 1});
    EXPECT_LE(scene.WorkspaceBytes(0), scene.WorkspaceBytes(1));
    EXPECT_LE(device->WorkspaceBytes(1000, 0), device->WorkspaceBytes(1000, 1));
    EXPECT_LE(device->WorkspaceBytes(0, 0), device->WorkspaceBytes(0, 1));
  }
}

/// Rays from within the box of a triangle of 1e18 to a side, which end long before they meet it.
std::vector<Ray> RaysThatEndEarly(std::size_t count) {
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const float beside = static_cast<float>(i) * 1e12f;
    rays.push_back(unit::MakeRay({1e17f + beside, beside, -1e17f}, {0, 0, 1}, 0, 1e4f));
  }
  return rays;
}

// Distance and limit, both times the length of the normal, were infinite, and the one not beyond
// the other: a hit at t = infinity for a ray that ends at 1e4.
TEST(SceneTest, ATriangleWhoseDistanceOverflowsIsNotWithinAFiniteTfar) {
  Mesh mesh;
  mesh.Add({0, 1e18f, 0}, {-1e18f, -1e18f, -1e18f}, {1e18f, -1e18f, 1e18f});
  const TriangleMesh view = mesh.View();
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    const auto device = std::make_shared<Device>(settings);
    const auto inner = std::make_shared<Scene>(device, std::span(&view, 1));
    Geometry instance;
    instance.shape = Shape::kInstance;
    instance.primitive_count = 1;
    instance.instanced_scene = inner;
    instance.transforms.resize(1);
    const Scene outer(device, std::span(&instance, 1), {});
    for (const Scene* const scene : {static_cast<const Scene*>(inner.get()), &outer}) {
      for (const std::size_t count : {1u, 16u, 100u, 1000u}) {
        std::vector<Ray> rays = RaysThatEndEarly(count);
        const std::vector<Ray> before = rays;
        for (const Query query : {Query::kClosest, Query::kAny}) {
          scene->Trace(query, unit::ViewOf(rays));
          for (std::size_t i = 0; i < count; ++i) ASSERT_TRUE(SameBits(rays[i], before[i])) << i;
        }
      }
    }
  }
}

#if defined(__SSE__)
/// Numbers too small for a normal form are zero for the calling thread, as long as this lives.
class FlushToZero {
 public:
  FlushToZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040); }
  ~FlushToZero() { _mm_setcsr(before_); }
  FlushToZero(const FlushToZero&) = delete;
  FlushToZero& operator=(const FlushToZero&) = delete;

 private:
  const unsigned before_;
};

// Programs that trace rays set these flags; threads of the library did not have them. The triangles
// are so small that distances times the length of a normal are zero with them: nothing is hit.
TEST(SceneTest, FlushToZeroIsTheCallersForAllThreads) {
  Random random(9);
  const Mesh mesh = unit::MakeSoup(random, 20000, 1e-13f, 1e-14f);
  const TriangleMesh view = mesh.View();
  // Threads that are started with the flags have them.
  const auto make_scene = [&](uint32_t threads) {
    Settings settings;
    settings.threads = threads;
    return Scene(std::make_shared<Device>(settings), {&view, 1});
  };
  const Scene by_one = make_scene(1), by_all = make_scene(0);
  const auto trace = [&](const Scene& scene) {
    Random ray_random(10);
    std::vector<Ray> rays = unit::MakeRays(ray_random, 50000, 1e-13f);
    scene.Trace(Query::kClosest, unit::ViewOf(rays));
    return rays;
  };
  const auto hits = [](const std::vector<Ray>& rays) {
    return std::count_if(rays.begin(), rays.end(), [](const Ray& ray) { return ray.IsHit(); });
  };
  const auto expect_same = [](const std::vector<Ray>& a, const std::vector<Ray>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(SameBits(a[i], b[i])) << i;
  };
  const auto with_small_numbers = trace(by_one);
  EXPECT_GT(hits(with_small_numbers), 100);
  expect_same(trace(by_all), with_small_numbers);
  const FlushToZero flush_to_zero;
  const auto without = trace(by_one);
  EXPECT_LT(hits(without), hits(with_small_numbers));
  for (int repeat = 0; repeat < 3; ++repeat) expect_same(trace(by_all), without);
}
#endif

}  // namespace
}  // namespace dacrt
