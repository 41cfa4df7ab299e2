// The API as a program meets it: own arrays, lambdas, progress, errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/callback_of.h"
#include "dacrt/dacrt.h"
#include "native_scene.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::kInfinity;
using unit::Random;

// What the header of the API shows.
TEST(NativeExampleTest, TenLinesFindAHit) {
  const std::vector<float> vertices = {0, 0, 0, 4, 0, 0, 0, 4, 0};
  const std::vector<uint32_t> triangles = {0, 1, 2};
  const Scene scene(std::make_shared<Device>(), Triangles(vertices, triangles));
  std::vector<RayHit> rays(2);
  rays[0].ray = {.org = {1, 2, 3}, .dir = {0, 0, -1}};
  rays[1].ray = {.org = {9, 9, 2}, .dir = {0, 0, -1}};
  scene.ClosestHits(rays);
  ASSERT_TRUE(rays[0].hit);
  EXPECT_EQ(rays[0].ray.tfar, 3);
  EXPECT_EQ(rays[0].hit.u, 0.25f);
  EXPECT_EQ(rays[0].hit.v, 0.5f);
  EXPECT_EQ(rays[0].Position(), (std::array<float, 3>{1, 2, 0}));
  EXPECT_EQ(rays[0].hit.geometry_id, 0u);
  EXPECT_EQ(rays[0].hit.instance_id, Hit::kNone);
  EXPECT_FALSE(rays[1].hit);
}

TEST_F(NativeTest, SingleRaysFindWhatBatchesFind) {
  for (const uint64_t budget : {kDefaultBudget, uint64_t{0}}) {
    const Scene scene(std::make_shared<Device>(Settings{.budget = budget}),
                      Triangles(mesh_.vertices, mesh_.triangles, 7));
    std::vector<RayHit> closest = rays_;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      EXPECT_EQ(scene.ClosestHit(closest[i]), bool(found_[i].hit));
      EXPECT_EQ(scene.AnyHit(rays_[i].ray), bool(found_[i].hit));
    }
    ExpectSame(closest);
  }
}

TEST_F(NativeTest, AnyHitsAreWrittenIntoTheRays) {
  std::vector<Ray> rays;
  for (const RayHit& ray : rays_) rays.push_back(ray.ray);
  const Statistics statistics = scene_->AnyHits(rays);
  EXPECT_EQ(statistics.rays, rays.size());
  EXPECT_EQ(statistics.hits, CountHits(found_));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(rays[i].IsOccluded(), bool(found_[i].hit));
  }
}

// -- Arrays of geometry ---------------------------------------------------------------------------

TEST_F(NativeTest, MeshesOverAnyArrays) {
  struct Vertex {
    double weight;
    Vector position;
    float colour[4];
  };
  std::vector<Vertex> interleaved;
  std::vector<float> flat;
  for (const Float3& vertex : mesh_.vertices) {
    interleaved.push_back({1, {vertex[0], vertex[1], vertex[2]}, {}});
    flat.insert(flat.end(), vertex.begin(), vertex.end());
  }
  flat.push_back(3);  // half a vertex
  std::vector<int> numbers;
  for (const auto& triangle : mesh_.triangles) {
    numbers.insert(numbers.end(), triangle.begin(), triangle.end());
  }
  for (const Geometry& geometry :
       {Triangles(flat, mesh_.triangles, 7), Triangles(flat, numbers, 7),
        Triangles({interleaved, &Vertex::position}, std::span(numbers), 7)}) {
    EXPECT_EQ(geometry.vertex_count, mesh_.vertices.size());
    std::vector<RayHit> rays = rays_;
    Scene(device_, geometry).ClosestHits(rays);
    ExpectSame(rays);
  }
  const Geometry halves[] = {Triangles(mesh_.vertices, std::span(mesh_.triangles).first(200), 3),
                             Triangles(mesh_.vertices, std::span(mesh_.triangles).subspan(200), 4)};
  std::vector<RayHit> rays = rays_;
  Scene(device_, halves).ClosestHits(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!found_[i].hit) continue;
    const uint32_t primitive = found_[i].hit.primitive_id;
    EXPECT_EQ(rays[i].hit.geometry_id, primitive < 200 ? 3u : 4u);
    EXPECT_EQ(rays[i].hit.primitive_id, primitive % 200 + (primitive >= 400 ? 200 : 0));
  }
  static_assert(!std::is_constructible_v<Groups<float, 3>, std::vector<float>>,
                "an array that is gone with the line");
}

TEST_F(NativeTest, AMovedInstanceShowsTheStillScene) {
  AffineTransform place;
  place.column[3][1] = 10;
  const std::shared_ptr<const Scene> still = std::move(scene_);
  const Scene moved(device_, InstanceOf(still, place, 5));
  std::vector<RayHit> rays = rays_;
  for (RayHit& ray : rays) ray.ray.org[1] += 10;
  moved.ClosestHits(rays);
  std::size_t same = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].hit) {
      EXPECT_EQ(rays[i].hit.instance_id, 5u);
    }
    same += rays[i].hit.primitive_id == found_[i].hit.primitive_id;
  }
  EXPECT_GE(same, rays.size() - 2) << "but for rounding";
}

// -- Callbacks ------------------------------------------------------------------------------------

TEST_F(NativeTest, FilterFunctionsOfLambdas) {
  std::atomic<int> marks = 0;
  const auto is_even = [](const RayHit& candidate) {
    return candidate.hit.primitive_id % 2 == 0 && candidate.ray.tfar > 0;
  };
  auto marks_even = [&](RayHit& candidate, const CallbackArguments& arguments) {
    marks += *static_cast<int*>(arguments.call);
    candidate.hit.u = 77;
    return is_even(candidate);
  };
  Geometry geometry = Triangles(mesh_.vertices, mesh_.triangles, 7);
  geometry.closest_filter = FilterOf(marks_even);
  geometry.any_filter = FilterOf(is_even);
  const Scene filtered(device_, geometry);

  std::vector<std::array<uint32_t, 3>> even = mesh_.triangles;
  for (std::size_t i = 1; i < even.size(); i += 2) even[i] = {0, 0, 0};
  const Scene expected(device_, Triangles(mesh_.vertices, even, 7));

  std::vector<RayHit> rays = rays_, others = rays_;
  int mark = 1;
  filtered.ClosestHits(rays, {.call = &mark});
  expected.ClosestHits(others);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(rays[i].hit.primitive_id, others[i].hit.primitive_id);
    EXPECT_EQ(rays[i].ray.tfar, others[i].ray.tfar);
    EXPECT_EQ(rays[i].hit.u, rays[i].hit ? 77 : 0);
    EXPECT_EQ(filtered.AnyHit(rays_[i].ray), bool(others[i].hit));
  }
  EXPECT_GE(marks, static_cast<int>(CountHits(others)));
}

TEST_F(NativeTest, UserPrimitivesOfLambdas) {
  const std::vector<std::array<float, 4>> spheres = {{0, 0, 5, 1}, {0, 0, 9, 2}, {4, 0, 5, 1}};
  const auto bounds = [&](uint32_t i) {
    const auto& [x, y, z, r] = spheres[i];
    return Bounds{{x - r, y - r, z - r}, {x + r, y + r, z + r}};
  };
  // Rays along z, from z = 0.
  const auto test = [&](uint32_t i, RayHit& ray) {
    const auto& [x, y, z, r] = spheres[i];
    const float dx = ray.ray.org[0] - x, dy = ray.ray.org[1] - y;
    if (dx * dx + dy * dy > r * r) return false;
    const float t = z - std::sqrt(r * r - dx * dx - dy * dy);
    if (t <= ray.ray.tnear || t > ray.ray.tfar) return false;
    ray.ray.tfar = t;
    ray.hit.u = 0.5f;
    return true;
  };
  const Geometry user = UserPrimitives(spheres.size(), BoundsOf(bounds), HitTestOf(test), 3);
  const Scene by_callback(device_, user), by_shape(device_, Spheres(spheres, 3));
  for (const float x : {-3.0f, -1.5f, 0.0f, 0.9f, 4.0f}) {
    RayHit ray{.ray = {.org = {x, 0, 0}, .dir = {0, 0, 1}}, .hit = {}};
    RayHit other = ray;
    EXPECT_EQ(by_callback.AnyHit(ray.ray), by_shape.AnyHit(ray.ray)) << x;
    EXPECT_EQ(by_callback.ClosestHit(ray), by_shape.ClosestHit(other)) << x;
    EXPECT_EQ(ray.hit.primitive_id, other.hit.primitive_id) << x;
    EXPECT_EQ(ray.hit.geometry_id, other.hit.geometry_id) << x;
    EXPECT_EQ(ray.hit.u, ray.hit ? 0.5f : 0);
    if (ray.hit) {
      EXPECT_NEAR(ray.ray.tfar, other.ray.tfar, 1e-5f) << x;
    }
  }
}

TEST_F(NativeTest, PointQueriesOfLambdas) {
  std::vector<bool> is_seen(mesh_.triangles.size());
  const auto visit = [&](const PointCandidate& candidate) {
    is_seen[candidate.primitive_id] = true;
    return candidate.radius;
  };
  Geometry geometry = Triangles(mesh_.vertices, mesh_.triangles);
  geometry.point_callback = PointVisitOf(visit);
  const Scene scene(device_, geometry);
  scene.QueryPoint({.point = {0, 0, 0}, .radius = kInfinity});
  EXPECT_EQ(std::ranges::count(is_seen, true), std::ssize(is_seen));
}

// -- Progress -------------------------------------------------------------------------------------

class NativeProgressTest : public NativeTest, public testing::WithParamInterface<uint64_t> {
 protected:
  const std::shared_ptr<Device> device_ =
      std::make_shared<Device>(Settings{.piece_rays = 128, .budget = GetParam()});
};

TEST_P(NativeProgressTest, ReachesTheWholeStepByStep) {
  const Scene scene(device_, Triangles(mesh_.vertices, mesh_.triangles, 7));
  std::vector<std::size_t> steps;
  const auto report = [&](std::size_t done, std::size_t rays) {
    EXPECT_EQ(rays, rays_.size());
    steps.push_back(done);
    return true;
  };
  std::vector<RayHit> rays = rays_;
  const Statistics statistics = scene.ClosestHits(rays, {.progress = ProgressOf(report)});
  ExpectSame(rays);
  EXPECT_EQ(steps.size(), statistics.pieces);
  EXPECT_GE(steps.size(), 8u);
  EXPECT_TRUE(std::ranges::is_sorted(steps));
  EXPECT_EQ(steps.back(), rays.size());
}

TEST_P(NativeProgressTest, ACancelledCallLeavesTheOtherRaysAsTheyWere) {
  const Scene scene(device_, Triangles(mesh_.vertices, mesh_.triangles, 7));
  std::size_t calls = 0;
  const auto cancel_at_second = [&](std::size_t, std::size_t) { return ++calls < 2; };
  std::vector<RayHit> rays = rays_;
  const Statistics statistics = scene.ClosestHits(rays, {.progress = ProgressOf(cancel_at_second)});
  EXPECT_EQ(calls, 2u) << "not called again";
  std::size_t answered = 0, untouched = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(SameBits(rays[i], found_[i]) || SameBits(rays[i], rays_[i])) << i;
    answered += bool(rays[i].hit);
    untouched += !rays[i].hit && found_[i].hit;
  }
  EXPECT_EQ(answered, statistics.hits);
  EXPECT_LT(statistics.rays, rays.size());
  EXPECT_GT(answered, 0u);
  EXPECT_GT(untouched, 0u);
  scene.ClosestHits(rays);  // a call that was cancelled can be made again
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(rays[i].hit.primitive_id, found_[i].hit.primitive_id);
  }
}

INSTANTIATE_TEST_SUITE_P(KeptAndNot, NativeProgressTest, testing::Values(kDefaultBudget, 0));

// -- Devices and errors ---------------------------------------------------------------------------

TEST_F(NativeTest, DevicesHaveMonitorsAndBudgetsOfTheirOwn) {
  std::atomic<std::ptrdiff_t> told[2] = {0, 0};
  for (const int i : {0, 1}) {
    const auto device = std::make_shared<Device>(Settings{.budget = i == 0 ? 0 : kDefaultBudget},
                                                 [&told, i](std::ptrdiff_t bytes) {
                                                   told[i] += bytes;
                                                   return true;
                                                 });
    const Scene scene(device, Triangles(mesh_.vertices, mesh_.triangles, 7));
    EXPECT_EQ(scene.KeptBytes() > 0, i == 1);
    std::vector<RayHit> rays = rays_;
    scene.ClosestHits(rays);
    ExpectSame(rays);
    EXPECT_GT(told[i], 0);
  }
  EXPECT_EQ(told[0], 0) << "all was given back";
  EXPECT_EQ(told[1], 0);
}

template <class Call>
Error ErrorOf(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {Error::Kind::kArgument, "", "", "", ""};
}

TEST_F(NativeTest, ErrorsNameFunctionArgumentAndValue) {
  Geometry geometry = Triangles(mesh_.vertices, mesh_.triangles, 31);
  geometry.vertices[0].data = nullptr;
  Geometry huge = Triangles(mesh_.vertices, mesh_.triangles, 32);
  huge.primitive_count = SIZE_MAX / 2;
  std::vector<RayHit> rays = rays_;
  RayView absent = ViewOf(rays), no_lanes = absent;
  absent.dir_y = RayView::kAbsent;
  no_lanes.lanes = 0;
  using enum Error::Kind;
  const struct {
    Error error;
    Error::Kind kind;
    std::string function, argument, value;
  } kCases[] = {
      {ErrorOf([&] { Scene(device_, geometry); }), kArgument, "Scene", "geometry 31: vertices",
       "null"},
      {ErrorOf([&] { Scene(device_, huge); }), kTooLarge, "Scene", "geometry 32: primitive count",
       std::to_string(SIZE_MAX / 2)},
      {ErrorOf([&] { Scene(nullptr, Triangles(mesh_.vertices, mesh_.triangles)); }), kArgument,
       "Scene", "device", "null"},
      {ErrorOf([&] { Scene(device_, InstanceOf(nullptr, {}, 5)); }), kArgument, "Scene",
       "geometry 5: instanced_scene", "null"},
      {ErrorOf([&] { Device(Settings{.bins = 77}); }), kArgument, "Settings", "bins", "\"77\""},
      {ErrorOf([&] { scene_->Trace(Query::kClosest, absent); }), kArgument, "Trace", "rays.dir_y",
       "kAbsent"},
      {ErrorOf([&] { scene_->Trace(Query::kClosest, no_lanes); }), kArgument, "Trace", "rays.lanes",
       "0"},
      {ErrorOf([&] { scene_->ClosestHits(rays, {.callback_width = 17}); }), kArgument, "Trace",
       "options.callback_width", "17"},
  };
  for (const auto& [error, kind, function, argument, value] : kCases) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    EXPECT_EQ(error.function(), function);
    EXPECT_EQ(error.argument(), argument);
    EXPECT_EQ(error.value(), value);
    EXPECT_TRUE(std::string(error.what()).starts_with(function + ": " + argument + " = " + value))
        << error.what();
  }
  for (std::size_t i = 0; i < rays.size(); ++i) EXPECT_TRUE(SameBits(rays[i], rays_[i]));
}

}  // namespace
}  // namespace dacrt
