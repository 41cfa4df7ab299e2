// Instances and moving shapes: where rays hit them, and their bounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "shape_scenes.h"

namespace dacrt {
namespace {

using unit::CountHits;
using unit::ExpectSameRays;
using unit::kInfinity;
using unit::MakeRays;
using unit::MakeScene;
using unit::MakeTriangles;
using unit::Model;
using unit::PointView;
using unit::Random;
using unit::TimedRay;
using unit::Trace;
using unit::TriangleView;

TEST(MovedShapesTest, InstancesAreMovedScenes) {
  Random random(6);
  const Model model = MakeTriangles(random, 1500);
  Model moved = model;
  // Powers of two, so that moving is exact.
  for (std::size_t i = 0; i < moved.steps[0].size(); ++i) {
    moved.steps[0][i] = 0.5f * moved.steps[0][i] + (i % 3 == 0 ? 4.0f : 0.0f);
  }
  const auto rays = MakeRays(random, 6000);
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    const auto device = std::make_shared<Device>(settings);
    const std::vector<Geometry> inner = {TriangleView(model, 7)};
    const auto scene = std::make_shared<Scene>(device, inner, SceneOptions{});
    std::vector<Geometry> outer(2);
    for (uint32_t i = 0; i < 2; ++i) {
      outer[i].shape = Shape::kInstance;
      outer[i].geometry_id = 10 + i;
      outer[i].primitive_count = 1;
      outer[i].instanced_scene = scene;
      outer[i].transforms.resize(1);
    }
    for (int axis = 0; axis < 3; ++axis) outer[1].transforms[0].matrix.column[axis][axis] = 0.5f;
    outer[1].transforms[0].matrix.column[3][0] = 4;
    const Scene top(device, outer, SceneOptions{});
    const std::vector<Geometry> flat = {TriangleView(model, 10), TriangleView(moved, 11)};
    const Scene reference(device, flat, SceneOptions{});
    const auto expected = Trace(reference, rays);
    const auto actual = Trace(top, rays);
    EXPECT_GT(CountHits(expected), 2000u);
    std::size_t different = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(actual[i].IsHit(), expected[i].IsHit()) << i;
      if (!actual[i].IsHit()) continue;
      EXPECT_EQ(actual[i].geometry_id, 7u);
      different += actual[i].instance_id != expected[i].geometry_id ||
                   actual[i].primitive_id != expected[i].primitive_id;
      EXPECT_NEAR(actual[i].tfar, expected[i].tfar, 1e-4f);
    }
    EXPECT_EQ(different, 0u);
    const auto blocked = Trace(top, rays, Query::kAny);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(blocked[i].tfar < 0, actual[i].IsHit());
    }
  }
}

// Of several that are equally far away the one with the smallest number in the scene itself counts,
// whatever the numbers in the instances are.
TEST(MovedShapesTest, TiesGoByTheNumbersOfInstances) {
  Random random(61);
  const Model model = MakeTriangles(random, 300);
  const auto rays = MakeRays(random, 2000);
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    const auto device = std::make_shared<Device>(settings);
    const auto scene_of = [&](uint32_t id) {
      const std::vector<Geometry> inner = {TriangleView(model, id)};
      return std::make_shared<Scene>(device, inner, SceneOptions{});
    };
    const auto instance = [&](uint32_t id, uint32_t inner_id) {
      Geometry geometry;
      geometry.shape = Shape::kInstance;
      geometry.geometry_id = id;
      geometry.primitive_count = 1;
      geometry.instanced_scene = scene_of(inner_id);
      geometry.transforms.resize(1);
      return geometry;
    };
    const std::vector<Geometry> first_instance = {instance(9, 1), instance(4, 8), instance(6, 2),
                                                  TriangleView(model, 5)};
    const std::vector<Geometry> first_triangles = {instance(9, 1), TriangleView(model, 3),
                                                   instance(4, 8)};
    const auto in_instance = Trace(Scene(device, first_instance, SceneOptions{}), rays);
    const auto in_scene = Trace(Scene(device, first_triangles, SceneOptions{}), rays);
    EXPECT_GT(CountHits(in_instance), 200u);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(in_instance[i].IsHit(), in_scene[i].IsHit());
      if (!in_instance[i].IsHit()) continue;
      ASSERT_EQ(in_instance[i].instance_id, 4u);
      ASSERT_EQ(in_instance[i].geometry_id, 8u);
      ASSERT_EQ(in_scene[i].instance_id, UINT32_MAX);
      ASSERT_EQ(in_scene[i].geometry_id, 3u);
    }
  }
}

/// An instance that turns half round the z axis between two steps, while its scene, far from the
/// origin, moves through places that neither step shows.
TEST(MovedShapesTest, LinearBoundsHoldARotationAtAllTimes) {
  Model model;
  model.steps = {{10, -1, 0, 10, 1, 0, 11, 0, 1}};
  model.indices = {0, 1, 2};
  const std::vector<Geometry> inner = {TriangleView(model, 0)};
  const auto device = std::make_shared<Device>();
  Geometry instance;
  instance.shape = Shape::kInstance;
  instance.primitive_count = 1;
  instance.instanced_scene = std::make_shared<Scene>(device, inner, SceneOptions{});
  for (const int halves : {0, 1, 2}) {
    TransformStep step;
    step.in_parts = true;
    step.parts.quaternion[0] = std::cos(static_cast<float>(halves) * 0.75f);
    step.parts.quaternion[3] = std::sin(static_cast<float>(halves) * 0.75f);
    instance.transforms.push_back(step);
    if (instance.transforms.size() < 2) continue;
    const LinearBounds bounds = Scene(device, {&instance, 1}, SceneOptions{}).linear_bounds();
    for (int i = 0; i <= 64; ++i) {
      const float time = static_cast<float>(i) / 64;
      const AffineTransform transform = TransformAt(instance.transforms, {}, time);
      for (int corner = 0; corner < 3; ++corner) {
        const float* const v = &model.steps[0][static_cast<std::size_t>(3 * corner)];
        for (int axis = 0; axis < 3; ++axis) {
          float at = transform.column[3][axis];
          for (int k = 0; k < 3; ++k) at += v[k] * transform.column[k][axis];
          const auto between = [&](float first, float last) {
            return first + (last - first) * time;
          };
          EXPECT_GE(at, between(bounds.begin.lower[axis], bounds.end.lower[axis]) - 1e-4f) << time;
          EXPECT_LE(at, between(bounds.begin.upper[axis], bounds.end.upper[axis]) + 1e-4f) << time;
        }
      }
    }
  }
}

// The circle that a turn is bounded by may reach further than coordinates may, though no point of
// the instance does.
TEST(MovedShapesTest, InstancesThatTurnFarAwayAreThereAtAllTimes) {
  constexpr float kUnit = 0x1p58f, kFar = 2;
  Model model;  // a sphere; the test of a triangle multiplies more than numbers hold
  model.steps = {{4.5f * kUnit, 0, 0, 0.5f * kUnit}};
  const std::vector<Geometry> inner = {PointView(model, Shape::kSpheres, 0)};
  Geometry instance;
  instance.shape = Shape::kInstance;
  instance.primitive_count = 1;
  for (const float angle : {0.0f, 0.5f}) {
    TransformStep step;
    step.in_parts = true;
    step.parts.quaternion[0] = std::cos(angle);
    step.parts.quaternion[3] = std::sin(angle);
    step.parts.translation[0] = -kFar * kUnit;
    step.parts.translation[1] = -kFar * kUnit;
    instance.transforms.push_back(step);
  }
  std::vector<TimedRay> rays;
  for (int i = 0; i <= 16; ++i) {
    TimedRay ray;
    ray.time = static_cast<float>(i) / 16;
    const AffineTransform transform = TransformAt(instance.transforms, {}, ray.time);
    for (int axis = 0; axis < 3; ++axis) {
      // To the sphere, from the origin of the instance.
      ray.org[static_cast<std::size_t>(axis)] = transform.column[3][axis];
      ray.dir[static_cast<std::size_t>(axis)] = transform.column[0][axis];
    }
    rays.push_back(ray);
  }
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    const auto device = std::make_shared<Device>(settings);
    instance.instanced_scene = std::make_shared<Scene>(device, inner, SceneOptions{});
    const Scene scene(device, {&instance, 1}, SceneOptions{});
    EXPECT_EQ(CountHits(Trace(scene, rays)), rays.size());
  }
}

// A geometry that is not there for all of the time from 0 to 1 has bounds that hold at any.
TEST(MovedShapesTest, LinearBoundsOfAnotherTimeRangeHoldAtAllTimes) {
  Model model;
  model.steps = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {10, 0, 0, 11, 0, 0, 10, 1, 0}};
  model.indices = {0, 1, 2};
  Geometry geometry = TriangleView(model, 0);
  for (const TimeRange& range : {TimeRange{0, 0.5f}, TimeRange{0.5f, 1}, TimeRange{0, 2}}) {
    geometry.time_range = range;
    const LinearBounds bounds = MakeScene({geometry}, kDefaultBudget)->linear_bounds();
    for (const Bounds& end : {bounds.begin, bounds.end}) {
      EXPECT_LE(end.lower[0], 0) << range.begin << " to " << range.end;
      EXPECT_GE(end.upper[0], 11) << range.begin << " to " << range.end;
    }
  }
}

TEST(MovedShapesTest, MovingTrianglesStandWhereTheirTimeSays) {
  Random random(7);
  Model model = MakeTriangles(random, 600);
  model.steps.push_back(model.steps[0]);
  model.steps.push_back(model.steps[0]);
  for (float& value : model.steps[1]) value += random.Uniform(-0.5f, 0.5f);
  for (float& value : model.steps[2]) value += random.Uniform(-0.5f, 0.5f);
  Geometry geometry = TriangleView(model, 1);
  geometry.time_range = {0.25f, 0.75f};
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) {
    const auto scene = MakeScene({geometry}, budget);
    for (const float time : {0.1f, 0.25f, 0.375f, 0.5f, 0.6f, 0.75f, 0.8f}) {
      auto rays = MakeRays(random, 500);
      for (TimedRay& ray : rays) ray.time = time;
      const auto actual = Trace(*scene, rays);
      if (time < 0.25f || time > 0.75f) {
        EXPECT_EQ(CountHits(actual), 0u);
        continue;
      }
      Model still = model;
      const float place = (time - 0.25f) / 0.5f * 2;
      const std::size_t step = place >= 1 ? 1 : 0;
      const float fraction = place - static_cast<float>(step);
      for (std::size_t i = 0; i < still.steps[0].size(); ++i) {
        still.steps[0][i] =
            std::fma(1 - fraction, model.steps[step][i], fraction * model.steps[step + 1][i]);
      }
      still.steps.resize(1);
      ExpectSameRays(actual, Trace(*MakeScene({TriangleView(still, 1)}, budget), rays),
                     "time " + std::to_string(time));
    }
  }
}

// One of two geometries that share leaves ends sooner than the other: rays that come later do not
// meet it where rays before them have.
TEST(MovedShapesTest, PointsThatAreGoneAreNotMetBesideOthers) {
  constexpr int kPoints = 200, kLanes = 10;
  Model models[2];
  for (Model& model : models) model.steps.resize(2);
  std::vector<TimedRay> rays;
  for (int i = 0; i < kPoints; ++i) {
    const auto x = static_cast<float>(i);
    for (auto& step : models[i % 2].steps) {
      for (const float value : {x, 0.0f, 0.0f, 0.4f}) step.push_back(value);
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      TimedRay ray;
      ray.org = {x, 0, -1};
      ray.dir = {0, 0, 1};
      ray.time = lane % 2 == 0 ? 0.25f : 0.75f;
      rays.push_back(ray);
    }
  }
  for (const std::size_t short_lived : {0u, 1u}) {
    std::vector<Geometry> geometries;
    for (uint32_t id : {0u, 1u}) {
      geometries.push_back(PointView(models[id], Shape::kSpheres, id));
    }
    geometries[short_lived].time_range = {0, 0.5f};
    const auto scene = MakeScene(geometries, kDefaultBudget);
    for (const Query query : {Query::kClosest, Query::kAny}) {
      const auto traced = Trace(*scene, rays, query);
      for (std::size_t i = 0; i < traced.size(); ++i) {
        const bool is_gone = i / kLanes % 2 == short_lived && traced[i].time > 0.5f;
        EXPECT_EQ(traced[i].tfar < kInfinity, !is_gone) << "ray " << i;
      }
    }
  }
}

}  // namespace
}  // namespace dacrt
