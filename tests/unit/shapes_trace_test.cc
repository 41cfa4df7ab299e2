// Scenes of every shape through the public API: right by what is known of each shape, and the same
// bits whatever the settings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "dacrt/ray.h"
#include "runtime/tasks.h"
#include "shape_scenes.h"

namespace dacrt {
namespace {

using unit::AcceptAll;
using unit::CountHits;
using unit::ExpectSameRays;
using unit::Float3;
using unit::kInfinity;
using unit::MakePoints;
using unit::MakeRays;
using unit::MakeScene;
using unit::MakeTriangles;
using unit::Model;
using unit::PointView;
using unit::Random;
using unit::Ray;
using unit::TimedRay;
using unit::TimedView;
using unit::Trace;
using unit::TriangleView;

TEST(ShapesTest, TrianglesThroughAFilterAreTheSame) {
  Random random(1);
  const Model model = MakeTriangles(random, 3000);
  Geometry geometry = TriangleView(model, 4);
  const auto plain = MakeScene({geometry}, kDefaultBudget);
  geometry.closest_filter = geometry.any_filter = {AcceptAll, nullptr};
  const auto rays = MakeRays(random, 5000);
  const auto expected = Trace(*plain, rays);
  EXPECT_GT(CountHits(expected), 1000u);
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    const auto scene = MakeScene({geometry}, budget);
    ExpectSameRays(Trace(*scene, rays), expected, "budget " + std::to_string(budget));
    ExpectSameRays(Trace(*scene, rays, Query::kAny), Trace(*plain, rays, Query::kAny), "any");
  }
}

// In a robust scene a ray passes a corner by a rounding, and u and v come out as a rounding more
// than one.
TEST(ShapesTest, CornersThroughAFilterAreTheSame) {
  Random random(11);
  const Model model = MakeTriangles(random, 2000);
  const Geometry plain = TriangleView(model, 4);
  Geometry filtered = plain;
  filtered.closest_filter = filtered.any_filter = {AcceptAll, nullptr};
  auto rays = MakeRays(random, 10 * 3 * 2000);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float corner = model.steps[0][i % 6000 * 3 + axis];
      rays[i].org[axis] = corner + 0.1f * rays[i].dir[axis];
      rays[i].dir[axis] = corner - rays[i].org[axis];
    }
  }
  for (const bool robust : {false, true}) {
    const auto expected = Trace(*MakeScene({plain}, kDefaultBudget, robust), rays);
    EXPECT_GT(std::count_if(expected.begin(), expected.end(),
                            [](const Ray& ray) { return ray.IsHit() && ray.u == 1; }),
              100);
    ExpectSameRays(Trace(*MakeScene({filtered}, kDefaultBudget, robust), rays), expected,
                   robust ? "robust" : "as ever");
  }
}

// Triangles that overlap in one plane, numbered against their order in space, of two geometries in
// turn. Beside a quad, which takes two lanes of a leaf, names decide; else numbers do.
TEST(ShapesTest, EqualDistancesBesideAQuadGoByNames) {
  Random random(12);
  constexpr int kCount = 600;
  Model models[2], quad;
  for (Model& model : models) model.steps.resize(1);
  for (int i = 0; i < kCount; ++i) {
    const float y = 1 - 2 * static_cast<float>(i) / kCount;
    Model& model = models[i % 2];
    for (const float value : {1.0f, y - 0.1f, -1.0f, 1.0f, y + 0.1f, -1.0f, 1.0f, y, 1.0f}) {
      model.steps[0].push_back(value);
    }
    for (int corner = 0; corner < 3; ++corner) {
      model.indices.push_back(static_cast<uint32_t>(model.indices.size()));
    }
  }
  quad.steps = {{5, 0, 0, 5, 1, 0, 5, 1, 1, 5, 0, 1}};
  quad.indices = {0, 1, 2, 3};
  Geometry beside = quad.View(3);
  beside.shape = Shape::kQuads;
  beside.geometry_id = 9;
  beside.primitive_count = 1;
  beside.primitives = {quad.indices.data(), 16};
  const Geometry odd = TriangleView(models[1], 4), even = TriangleView(models[0], 8);
  std::vector<TimedRay> rays(2000);
  for (TimedRay& ray : rays) {
    ray.org = {-1, random.Uniform(-1, 1), random.Uniform(-1, 1)};
    ray.dir = {1, 0, 0};
    ray.tfar = 4;
  }
  const auto expected = Trace(*MakeScene({odd, even}, kDefaultBudget), rays);
  EXPECT_GT(CountHits(expected), 1000u);
  for (const TimedRay& ray : expected) {
    float least = kInfinity;
    for (int i = 1; i < kCount; i += 2) {
      const float* const v = models[1].steps[0].data() + 9 * (i / 2);
      const float half = 0.1f * (1 - ray.org[2]) / 2;
      if (std::abs(ray.org[1] - v[7]) < 0.999f * half) least = std::min(least, float(i / 2));
    }
    if (!ray.IsHit() || least == kInfinity) continue;
    EXPECT_EQ(ray.geometry_id, 4u);
    EXPECT_LE(ray.primitive_id, least);
  }
  for (const auto& scene : {MakeScene({odd, even, beside}, kDefaultBudget),
                            MakeScene({beside, even, odd}, kDefaultBudget)}) {
    ExpectSameRays(Trace(*scene, rays), expected, "beside a quad");
  }
}

TEST(ShapesTest, QuadsAreTheirTwoTriangles) {
  Random random(2);
  Model quads, triangles;
  quads.steps.resize(1);
  for (int i = 0; i < 800; ++i) {
    const Float3 at = random.InCube(-2, 2), a = random.InCube(-0.4f, 0.4f),
                 b = random.InCube(-0.4f, 0.4f);
    const uint32_t first = static_cast<uint32_t>(quads.steps[0].size() / 3);
    for (const auto& [s, t] : {std::pair{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        quads.steps[0].push_back(at[axis] + s * a[axis] + t * b[axis]);
      }
    }
    for (uint32_t corner = 0; corner < 4; ++corner) quads.indices.push_back(first + corner);
    for (const uint32_t corner : {0, 1, 3, 2, 3, 1}) triangles.indices.push_back(first + corner);
  }
  triangles.steps = quads.steps;
  Geometry geometry = quads.View(3);
  geometry.shape = Shape::kQuads;
  geometry.primitive_count = 800;
  geometry.primitives = {quads.indices.data(), 16};
  const auto rays = MakeRays(random, 4000);
  const auto expected = Trace(*MakeScene({TriangleView(triangles, 0)}, kDefaultBudget), rays);
  const auto actual = Trace(*MakeScene({geometry}, kDefaultBudget), rays);
  EXPECT_GT(CountHits(expected), 500u);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(actual[i].IsHit(), expected[i].IsHit()) << i;
    if (!actual[i].IsHit()) continue;
    EXPECT_EQ(actual[i].tfar, expected[i].tfar);
    EXPECT_EQ(actual[i].primitive_id, expected[i].primitive_id / 2);
    const bool second = expected[i].primitive_id % 2 == 1;
    EXPECT_EQ(actual[i].u, second ? 1 - expected[i].u : expected[i].u);
    EXPECT_EQ(actual[i].v, second ? 1 - expected[i].v : expected[i].v);
  }
}

TEST(ShapesTest, GridsLieBetweenTheirVertices) {
  Model model;
  model.steps.resize(1);
  constexpr uint32_t kWidth = 9, kHeight = 6;
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      for (const float value : {static_cast<float>(x), static_cast<float>(y), 0.0f}) {
        model.steps[0].push_back(value);
      }
    }
  }
  model.grids = {{0, kWidth, kWidth, kHeight}};
  Geometry geometry = model.View(3);
  geometry.shape = Shape::kGrids;
  geometry.primitive_count = 1;
  geometry.primitives = {model.grids.data(), sizeof(GridPrimitive)};
  Random random(3);
  std::vector<TimedRay> rays(500);
  for (TimedRay& ray : rays) {
    ray.org = {random.Uniform(-1, 9), random.Uniform(-1, 6), 2};
    ray.dir = {0, 0, -1};
  }
  const auto hits = Trace(*MakeScene({geometry}, kDefaultBudget), rays);
  EXPECT_GT(CountHits(hits), 200u);
  for (const TimedRay& ray : hits) {
    const float x = ray.org[0], y = ray.org[1];
    ASSERT_EQ(ray.IsHit(), x >= 0 && x <= kWidth - 1 && y >= 0 && y <= kHeight - 1);
    if (!ray.IsHit()) continue;
    EXPECT_EQ(ray.primitive_id, 0u);
    EXPECT_NEAR(ray.u, x / (kWidth - 1), 1e-6f);
    EXPECT_NEAR(ray.v, y / (kHeight - 1), 1e-6f);
    EXPECT_EQ(ray.tfar, 2.0f);
  }
}

TEST(ShapesTest, SpheresAreHitWhereTheirEquationSays) {
  Random random(4);
  const Model model = MakePoints(random, 700);
  const auto scene = MakeScene({PointView(model, Shape::kSpheres, 3)}, kDefaultBudget);
  const auto rays = Trace(*scene, MakeRays(random, 4000));
  EXPECT_GT(CountHits(rays), 1000u);
  for (const TimedRay& ray : rays) {
    double nearest = kInfinity;
    bool in_doubt = false;
    for (std::size_t i = 0; i < 700; ++i) {
      const float* sphere = &model.steps[0][4 * i];
      double b = 0, c = 0, d2 = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double to = double{sphere[axis]} - ray.org[axis];
        b += to * ray.dir[axis];
        c += to * to;
        d2 += double{ray.dir[axis]} * ray.dir[axis];
      }
      b /= d2;
      const double half2 = double{sphere[3]} * sphere[3] / d2 - (c / d2 - b * b);
      in_doubt |= std::abs(half2) < 1e-5;
      if (half2 < 0) continue;
      for (const double t : {b - std::sqrt(half2), b + std::sqrt(half2)}) {
        if (t >= 0) nearest = std::min(nearest, t);
      }
    }
    if (in_doubt) continue;
    ASSERT_EQ(ray.IsHit(), nearest < kInfinity);
    if (ray.IsHit()) {
      ASSERT_NEAR(ray.tfar, nearest, 1e-3);
    }
  }
}

/// Intersects the spheres of a Model; the same answers as a sphere geometry.
struct UserSpheres {
  const Model& model;
  std::size_t calls = 0, rays = 0;

  static void Bound(void* data, uint32_t primitive, uint32_t, Bounds& bounds) {
    const float* sphere = &static_cast<UserSpheres*>(data)->model.steps[0][4 * primitive];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.lower[axis] = sphere[axis] - sphere[3];
      bounds.upper[axis] = sphere[axis] + sphere[3];
    }
  }

  static void Intersect(void* data, const CallbackArguments& arguments) {
    auto& self = *static_cast<UserSpheres*>(data);
    ++self.calls;
    const float* sphere = &self.model.steps[0][4 * arguments.primitive_id];
    const auto at = [&](PacketComponent component, std::size_t lane) -> float& {
      return static_cast<float*>(
          arguments.packet)[static_cast<std::size_t>(component) * arguments.width + lane];
    };
    for (std::size_t lane = 0; lane < arguments.width; ++lane) {
      if (!arguments.valid[lane]) continue;
      ++self.rays;
      float b = 0, c = 0;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const float to = sphere[axis] - at(static_cast<PacketComponent>(axis), lane);
        b += to * at(static_cast<PacketComponent>(4 + axis), lane);
        c += to * to;
      }
      const float half2 = sphere[3] * sphere[3] - (c - b * b);
      if (half2 < 0) continue;
      float t = b - std::sqrt(half2);
      if (t < 0) t = b + std::sqrt(half2);
      if (t < 0 || t > at(PacketComponent::kTfar, lane)) continue;
      if (arguments.query == Query::kAny) {
        at(PacketComponent::kTfar, lane) = -kInfinity;
        continue;
      }
      at(PacketComponent::kTfar, lane) = t;
      const auto put = [&](PacketComponent component, uint32_t value) {
        std::memcpy(&at(component, lane), &value, sizeof(value));
      };
      put(PacketComponent::kPrimitiveId, arguments.primitive_id);
      put(PacketComponent::kGeometryId, arguments.geometry_id);
      put(PacketComponent::kInstanceId, arguments.instance_id);
    }
  }

  Geometry View(uint32_t id) {
    Geometry geometry;
    geometry.shape = Shape::kUser;
    geometry.geometry_id = id;
    geometry.primitive_count = model.steps[0].size() / 4;
    geometry.bounds = {Bound, this};
    geometry.intersect = geometry.occluded = {Intersect, this};
    return geometry;
  }
};

TEST(ShapesTest, UserSpheresAreSpheres) {
  Random random(5);
  const Model model = MakePoints(random, 500);
  UserSpheres user{model};
  const auto rays = MakeRays(random, 3000);
  const auto expected = Trace(*MakeScene({PointView(model, Shape::kSpheres, 3)}, 0), rays);
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    for (const uint32_t width : {1u, 4u, 8u, 16u}) {
      const auto scene = MakeScene({user.View(3)}, budget);
      user.calls = user.rays = 0;
      const auto actual = Trace(*scene, rays, Query::kClosest, {width, nullptr});
      std::size_t same = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        same += actual[i].primitive_id == expected[i].primitive_id;
      }
      EXPECT_GE(same, rays.size() - 3);
      if (width > 1 && budget == 0) {
        EXPECT_LT(2 * user.calls, user.rays);
      }
      const auto blocked = Trace(*scene, rays, Query::kAny, {width, nullptr});
      for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(blocked[i].tfar < 0, actual[i].IsHit());
      }
    }
  }
}

/// Records which pairs it is offered, and rejects them all.
struct Recorder {
  std::map<std::pair<uint32_t, uint32_t>, int> offered;

  static void Reject(void* data, const CallbackArguments& arguments) {
    const auto at = [&](PacketComponent component, std::size_t lane) {
      return static_cast<uint32_t*>(
          arguments.packet)[static_cast<std::size_t>(component) * arguments.width + lane];
    };
    for (std::size_t lane = 0; lane < arguments.width; ++lane) {
      if (!arguments.valid[lane]) continue;
      ++static_cast<Recorder*>(data)
            ->offered[{at(PacketComponent::kId, lane), at(PacketComponent::kPrimitiveId, lane)}];
      arguments.valid[lane] = 0;
    }
  }
};

TEST(ShapesTest, FilterFunctionsAreOfferedEachPairOnce) {
  Random random(8);
  const Model model = MakeTriangles(random, 2500);
  Geometry geometry = TriangleView(model, 1);
  std::vector<TimedRay> rays = MakeRays(random, 700);
  std::map<std::pair<uint32_t, uint32_t>, int> expected;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    // The time's place serves as the ray's name.
    const uint32_t id = static_cast<uint32_t>(i);
    std::memcpy(&rays[i].time, &id, sizeof(id));
  }
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Recorder recorder;
    geometry.closest_filter = {Recorder::Reject, &recorder};
    const auto scene = MakeScene({geometry}, budget);
    std::vector<TimedRay> traced = rays;
    RayView view = TimedView(traced);
    view.id = view.time;
    view.time = RayView::kAbsent;
    scene->Trace(Query::kClosest, view);
    EXPECT_EQ(CountHits(traced), 0u);
    ExpectSameRays(traced, rays, "rejected hits leave rays as they were");
    EXPECT_GT(recorder.offered.size(), 1000u);
    for (const auto& [pair, times] : recorder.offered) ASSERT_EQ(times, 1);
    if (expected.empty()) expected = recorder.offered;
    EXPECT_EQ(recorder.offered, expected);
  }
}

/// Whether a ray is blocked that comes in a call of its own.
bool IsBlockedAlone(const Scene& scene, const TimedRay& ray) {
  RayHit alone;
  std::copy_n(std::begin(ray.org), 3, alone.ray.org);
  std::copy_n(std::begin(ray.dir), 3, alone.ray.dir);
  alone.ray.tnear = ray.tnear;
  alone.ray.tfar = ray.tfar;
  alone.ray.time = ray.time;
  alone.ray.mask = ray.mask;
  scene.Trace(Query::kAny, RayPacket{.values = &alone, .lanes = 1}, {1, nullptr});
  return alone.ray.tfar < 0;
}

// What a ray meets behind, or beside, what blocks it is no question any more.
TEST(ShapesTest, AFilterFunctionIsNotAskedAboutRaysThatAreBlocked) {
  Random random(81);
  Model model = MakeTriangles(random, 200);
  // Each triangle several times, so that they stand in one leaf.
  const std::vector<uint32_t> once = model.indices;
  for (int times = 1; times < 6; ++times) {
    model.indices.insert(model.indices.end(), once.begin(), once.end());
  }
  Model points = MakePoints(random, 300);
  const auto rays = MakeRays(random, 3000);
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    for (const bool robust : {false, true}) {
      for (const bool is_triangles : {false, true}) {
        Geometry geometry =
            is_triangles ? TriangleView(model, 0) : PointView(points, Shape::kSpheres, 0);
        std::size_t asked = 0;
        geometry.any_filter = {unit::CountAsked, &asked};
        const auto scene = MakeScene({geometry}, budget, robust);
        const auto traced = Trace(*scene, rays, Query::kAny);
        const auto blocked = std::count_if(traced.begin(), traced.end(),
                                           [](const Ray& ray) { return ray.tfar < 0; });
        EXPECT_GT(blocked, 300);
        EXPECT_EQ(asked, static_cast<std::size_t>(blocked));
        asked = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
          ASSERT_EQ(IsBlockedAlone(*scene, rays[i]), traced[i].tfar < 0) << "ray " << i;
        }
        EXPECT_EQ(asked, static_cast<std::size_t>(blocked));
      }
    }
  }
}

TEST(ShapesTest, TheSameBitsWhateverIsKept) {
  Random random(9);
  const Model triangles = MakeTriangles(random, 2000), spheres = MakePoints(random, 900),
              discs = MakePoints(random, 900), oriented = MakePoints(random, 900);
  const std::vector<Geometry> geometries = {
      TriangleView(triangles, 0), PointView(spheres, Shape::kSpheres, 1),
      PointView(discs, Shape::kDiscs, 2), PointView(oriented, Shape::kOrientedDiscs, 3)};
  const auto rays = MakeRays(random, 20000);
  for (const bool robust : {false, true}) {
    const auto expected = Trace(*MakeScene(geometries, 0, robust), rays);
    std::set<uint32_t> hit;
    for (const TimedRay& ray : expected) hit.insert(ray.geometry_id);
    EXPECT_EQ(hit.size(), 5u);
    for (const uint64_t budget : {uint64_t{60000}, kDefaultBudget, kUnlimitedBudget}) {
      for (const uint32_t threads : {1u, 2u}) {
        ExpectSameRays(Trace(*MakeScene(geometries, budget, robust, threads), rays), expected,
                       "budget " + std::to_string(budget));
      }
    }
  }
}

/// A program that walks from hit to hit lost those at the distance of the last one.
TEST(ShapesTest, InRobustScenesARayThatGoesOnFromAHitMeetsItAgain) {
  Random random(12);
  const Model model = MakeTriangles(random, 2000);
  const auto scene = MakeScene({TriangleView(model, 0)}, kDefaultBudget, true);
  const auto first = Trace(*scene, MakeRays(random, 5000));
  std::vector<TimedRay> rays = first;
  for (TimedRay& ray : rays) {
    ray.tnear = ray.tfar;
    ray.geometry_id = ray.primitive_id = UINT32_MAX;
  }
  EXPECT_GT(CountHits(first), 1000u);
  const auto again = Trace(*scene, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_EQ(again[i].tfar, first[i].tfar) << i;
    EXPECT_EQ(again[i].primitive_id, first[i].primitive_id) << i;
  }
}

// Programs that call from several threads have work for all of them. A call that a callback makes
// runs at once with its own.
TEST(ShapesTest, CallsThatRunAtOnceShareTheThreads) {
  Random random(12);
  Settings settings;
  settings.threads = 2;
  const auto device = std::make_shared<Device>(settings);
  const Model model = MakeTriangles(random, 300);
  Geometry triangles = TriangleView(model, 0);
  const Scene inner(device, {&triangles, 1}, SceneOptions{});
  struct InnerCall {
    const Scene& scene;
    const std::vector<TimedRay> rays;
    uint64_t pieces = 0;
    int calls = 0;

    void Make() {
      if (++calls > 4) return;  // they are long
      std::vector<TimedRay> copy = rays;
      pieces = scene.Trace(Query::kClosest, TimedView(copy)).pieces;
    }
  } call{inner, MakeRays(random, 10000)};
  call.Make();
  EXPECT_EQ(call.pieces > 1, TaskPool(2).threads() > 1);
  triangles.closest_filter = {
      [](void* data, const CallbackArguments&) { static_cast<InnerCall*>(data)->Make(); }, &call};
  const Scene outer(device, {&triangles, 1}, SceneOptions{});
  // So many that they do not go the short way, which is the caller's alone.
  const auto rays = Trace(outer, MakeRays(random, 300));
  EXPECT_GT(CountHits(rays), 0u);
  EXPECT_GT(call.calls, 1);
  EXPECT_EQ(call.pieces, 1u);
}

TEST(ShapesTest, BadInputIsRefused) {
  Random random(11);
  const Model model = MakeTriangles(random, 3);
  const auto device = std::make_shared<Device>();
  const auto refuse = [&](const Geometry& geometry) {
    const std::vector<Geometry> geometries = {geometry};
    EXPECT_THROW(Scene(device, geometries, SceneOptions{}), std::invalid_argument);
  };
  Geometry geometry = TriangleView(model, 0);
  geometry.vertices.clear();
  refuse(geometry);
  geometry = TriangleView(model, 0);
  geometry.shape = Shape::kQuads;
  geometry.vertices[0].stride = 13;
  refuse(geometry);
  geometry = Geometry();
  geometry.shape = Shape::kInstance;
  geometry.transforms.resize(1);
  refuse(geometry);  // no scene
  const std::vector<Geometry> inner = {TriangleView(model, 0)};
  geometry.instanced_scene =
      std::make_shared<Scene>(std::make_shared<Device>(), inner, SceneOptions{});
  refuse(geometry);  // another device's
  geometry.instanced_scene = std::make_shared<Scene>(device, inner, SceneOptions{});
  geometry.transforms.clear();
  refuse(geometry);

  const Scene scene(device, inner, SceneOptions{});
  std::vector<TimedRay> rays = MakeRays(random, 1);
  EXPECT_THROW(scene.Trace(Query::kClosest, TimedView(rays), {17, nullptr}), std::invalid_argument);
  EXPECT_THROW(scene.Trace(Query::kClosest, TimedView(rays), {0, nullptr}), std::invalid_argument);
}

}  // namespace
}  // namespace dacrt
