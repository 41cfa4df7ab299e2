// What becomes a ray's hit, where it is easily too much: at the ray's end, behind its origin,
// beyond an edge, and where a program's function says what it must not say.
#include "leaf/take_hit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "forms.h"
#include "shape_scenes.h"

namespace dacrt {
namespace {

using unit::FullRay;
using unit::kInfinity;
using unit::MakeScene;
using unit::Model;
using unit::Random;
using unit::TimedRay;
using unit::Trace;

/// A ray in all lanes of a packet, and in the end what is in the last one.
FullRay TraceLanes(const Scene& scene, const unit::Ray& ray, uint32_t lanes,
                   bool has_masks = true) {
  FullRay full = unit::FullRayOf(ray);
  std::vector<uint32_t> values;
  for (const uint32_t bits : full.bits) values.insert(values.end(), lanes, bits);
  RayPacket packet;
  packet.values = values.data();
  packet.lanes = lanes;
  packet.has_masks = has_masks;
  scene.Trace(Query::kClosest, packet, {lanes, nullptr});
  for (std::size_t c = 0; c < kPacketComponents; ++c) full.bits[c] = values[(c + 1) * lanes - 1];
  return full;
}

// A hit at the ray's own end may round to a larger distance. The next one there is as near.
TEST(TakeHitTest, HitsAtTheRaysEndAreEquallyNear) {
  const float beyond = std::nextafter(1.0f, 2.0f);
  RayRecord ray{};
  ray.tfar = 1;
  ray.state = RayRecord::kAtLimit;
  ASSERT_EQ(Compare(ray, beyond, true), Closeness::kCloser);
  SetHit(ray, beyond, 0, 0);
  EXPECT_EQ(ray.tfar, 1);
  EXPECT_EQ(Compare(ray, beyond, true), Closeness::kEqual);
  EXPECT_EQ(Compare(ray, beyond, false), Closeness::kFarther);
  SetHit(ray, 0.5f, 0, 0);
  EXPECT_EQ(Compare(ray, beyond, true), Closeness::kFarther);
}

// A negative tnear counts as zero for spheres and discs, as it does for the boxes round them.
TEST(TakeHitTest, PointsBehindTheOriginAreMissed) {
  Model model;
  model.steps = {{0, 0, -0.5f, 1, 0, 0, 0.5f, 1}};
  model.normals = {0, 0, 1, 0, 0, 1};
  TimedRay ray;
  ray.org = {0.1f, 0.1f, 0};
  ray.dir = {0, 0, 1};
  ray.tnear = -10;
  for (const Shape shape : {Shape::kSpheres, Shape::kOrientedDiscs}) {
    const auto hits = Trace(*MakeScene({unit::PointView(model, shape, 3)}, kDefaultBudget), {ray});
    ASSERT_TRUE(hits[0].IsHit());
    EXPECT_GE(hits[0].tfar, 0);
  }
}

// The edge tests of robust scenes have a slack, by which a quotient may be more than one.
TEST(TakeHitTest, RobustHitsAreWithinTheirTriangle) {
  Random random(5);
  Model model;
  model.steps.resize(1);
  constexpr uint32_t kTriangles = 200;
  for (uint32_t i = 0; i < 3 * kTriangles; ++i) {
    for (const float value : random.InCube(-1, 1)) model.steps[0].push_back(value);
    model.indices.push_back(i);
  }
  Geometry geometry = model.View(3);
  geometry.shape = Shape::kTriangles;
  geometry.primitive_count = kTriangles;
  geometry.primitives = {model.indices.data(), 12};
  std::vector<TimedRay> rays(20000);
  for (TimedRay& ray : rays) {
    ray.org = random.InCube(-3, 3);
    const float* corner = &model.steps[0][3 * random.Below(3 * kTriangles)];
    for (std::size_t axis = 0; axis < 3; ++axis) ray.dir[axis] = corner[axis] - ray.org[axis];
  }
  std::size_t at_corners = 0;
  for (const TimedRay& ray : Trace(*MakeScene({geometry}, kDefaultBudget, true), rays)) {
    if (!ray.IsHit()) continue;
    ASSERT_LE(ray.u, 1);
    ASSERT_LE(ray.v, 1);
    at_corners += ray.u == 1 || ray.v == 1;
  }
  EXPECT_GT(at_corners, 10u);
}

/// Hits at 5 when it is called first, and at 50, which is no hit any more, from then on.
void HitFartherThanBefore(void* data, const CallbackArguments& arguments) {
  auto& calls = *static_cast<int*>(data);
  const float t = calls++ == 0 ? 5 : 50;
  const auto put = [&](PacketComponent component, const auto& value) {
    for (uint32_t lane = 0; lane < arguments.width; ++lane) {
      std::memcpy(static_cast<float*>(arguments.packet) +
                      static_cast<std::size_t>(component) * arguments.width + lane,
                  &value, sizeof(value));
    }
  };
  put(PacketComponent::kTfar, t);
  put(PacketComponent::kGeometryId, arguments.geometry_id);
  put(PacketComponent::kPrimitiveId, arguments.primitive_id);
}

// What lies between the two is found no more.
TEST(TakeHitTest, UserFunctionsDoNotMoveARaysEndAway) {
  int calls = 0;
  Geometry user;
  user.shape = Shape::kUser;
  user.geometry_id = 2;
  user.primitive_count = 2;
  user.bounds = {[](void*, uint32_t, uint32_t, Bounds& bounds) {
                   bounds = {{-1, -1, 0}, {1, 1, 1}};
                 },
                 nullptr};
  user.intersect = {HitFartherThanBefore, &calls};
  // Many triangles, so that they stand in leaves of their own.
  Model model;
  model.steps.resize(1);
  constexpr uint32_t kTriangles = 256;
  for (uint32_t i = 0; i < kTriangles; ++i) {
    const float x = static_cast<float>(i % 16) - 8, y = static_cast<float>(i / 16) - 8;
    for (const float value : {x, y, 20.0f, x + 2, y, 20.0f, x, y + 2, 20.0f}) {
      model.steps[0].push_back(value);
    }
    for (uint32_t corner = 0; corner < 3; ++corner) model.indices.push_back(3 * i + corner);
  }
  Geometry behind = model.View(3);
  behind.shape = Shape::kTriangles;
  behind.geometry_id = 3;
  behind.primitive_count = kTriangles;
  behind.primitives = {model.indices.data(), 12};
  TimedRay ray;
  ray.org = {0.3f, 0.3f, -1};
  ray.dir = {0, 0, 1};
  const auto scene = MakeScene({user, behind}, kDefaultBudget);
  const auto hits = Trace(*scene, {ray}, Query::kClosest, {1, nullptr});
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(hits[0].geometry_id, 2u);
  for (const uint32_t lanes : {1u, 8u}) {
    calls = 0;
    const FullRay hit = TraceLanes(*scene, ray, lanes);
    EXPECT_EQ(calls, 2);
    EXPECT_EQ(hit.Get<uint32_t>(PacketComponent::kGeometryId), 2u) << lanes << " lanes";
  }
}

/// Accepts all hits, and says that they are half as far.
void HalveTheDistance(void*, const CallbackArguments& arguments) {
  float* const tfar = static_cast<float*>(arguments.packet) +
                      static_cast<std::size_t>(PacketComponent::kTfar) * arguments.width;
  for (uint32_t lane = 0; lane < arguments.width; ++lane) tfar[lane] /= 2;
}

// What lies between the distance that a filter function was shown and the one that it sets is no
// closer hit.
TEST(TakeHitTest, ARayEndsWhereTheFilterFunctionSays) {
  const float vertex[3] = {};
  Geometry geometry;
  geometry.vertices = {{vertex, 12}};
  geometry.closest_filter = {HalveTheDistance, nullptr};
  const SceneParts* const no_scene = nullptr;
  const SceneParts scene{GeometryTable({&geometry, 1}, {&no_scene, 1}, false)};
  std::vector<unit::Ray> rays(1);
  const RayView view = unit::ViewOf(rays);
  const CallOptions options;
  const CallFrame frame{&view, nullptr, 0, options, UINT32_MAX};
  const auto scratch = std::make_unique<SubsetScratch>();
  SplitMemory split_memory(*scratch);
  RayRecord ray{};
  ray.tfar = kInfinity;
  ray.state = RayRecord::kAtLimit;
  FullHit hit{};
  const TraceTask task{scene, {},           &ray, &hit,    false,   false,
                       frame, split_memory, {},   nullptr, nullptr, UINT32_MAX};
  Candidate candidate{};
  candidate.within_limit = true;
  candidate.key = candidate.t = 8;
  TakeHit<Query::kClosest>(task, 0, candidate);
  EXPECT_EQ(ray.tfar, 4);
  EXPECT_EQ(hit.t, 4);
  candidate.key = candidate.t = 5;
  candidate.primitive_id = 1;
  TakeHit<Query::kClosest>(task, 0, candidate);
  EXPECT_EQ(hit.primitive_id, 0u);
}

/// Accepts all hits, and says that they are three times as far.
void TripleTheDistance(void*, const CallbackArguments& arguments) {
  float* const tfar = static_cast<float*>(arguments.packet) +
                      static_cast<std::size_t>(PacketComponent::kTfar) * arguments.width;
  for (uint32_t lane = 0; lane < arguments.width; ++lane) tfar[lane] *= 3;
}

// Single rays, groups and lists alike: a hit that the filter function moves away gives way to one
// that lies before its new place.
TEST(TakeHitTest, AHitIsWhereTheFilterFunctionPutsIt) {
  const float z[] = {1, 2};
  const uint32_t indices[3] = {0, 1, 2};
  float vertices[2][3][3];
  std::vector<Geometry> geometries(2);
  for (uint32_t i = 0; i < 2; ++i) {
    const float corners[3][3] = {{-9, -9, z[i]}, {9, -9, z[i]}, {0, 9, z[i]}};
    std::memcpy(vertices[i], corners, sizeof(corners));
    geometries[i].geometry_id = i;
    geometries[i].vertices = {{vertices[i], 12}};
    geometries[i].vertex_count = 3;
    geometries[i].primitives = {indices, 12};
    geometries[i].primitive_count = 1;
  }
  geometries[0].closest_filter = {TripleTheDistance, nullptr};
  Random random(2);
  const auto test = [&](uint64_t budget) {
    const auto scene = MakeScene(geometries, budget);
    for (const std::size_t count : {1u, 16u, 1000u}) {
      for (const uint32_t width : {1u, 8u}) {
        std::vector<TimedRay> rays(count);
        for (TimedRay& ray : rays) {
          ray.org = random.InCube(-0.5f, 0.5f);
          ray.dir = {random.Uniform(-0.1f, 0.1f), random.Uniform(-0.1f, 0.1f), 1};
        }
        for (const TimedRay& ray : Trace(*scene, rays, Query::kClosest, {width, nullptr})) {
          ASSERT_EQ(ray.geometry_id, 1u)
              << count << " rays, width " << width << ", budget " << budget;
          ASSERT_LT(ray.tfar, 2.6f);
        }
      }
    }
    for (const uint32_t lanes : {1u, 8u}) {
      const FullRay hit = TraceLanes(*scene, unit::MakeRay({0, 0, 0}, {0, 0, 1}), lanes);
      EXPECT_EQ(hit.Get<uint32_t>(PacketComponent::kGeometryId), 1u);
      EXPECT_EQ(hit.Get(PacketComponent::kTfar), 2);
    }
  };
  for (const uint64_t budget : {uint64_t{0}, kDefaultBudget}) test(budget);
  geometries.push_back(unit::UserGeometry(2));
  test(kDefaultBudget);
}

std::shared_ptr<const Scene> SceneOf(const std::shared_ptr<Device>& device,
                                     const std::vector<Geometry>& geometries) {
  return std::make_shared<Scene>(device, geometries, SceneOptions{});
}

Geometry InstanceOf(std::shared_ptr<const Scene> scene) {
  Geometry instance;
  instance.shape = Shape::kInstance;
  instance.primitive_count = 1;
  instance.instanced_scene = std::move(scene);
  instance.transforms.resize(1);
  return instance;
}

// There is one level of instances.
TEST(TakeHitTest, AnInstanceInAnInstanceIsNotThere) {
  Random random(8);
  const Model triangles = unit::MakeTriangles(random, 2000);
  const auto device = std::make_shared<Device>();
  const auto inner = SceneOf(device, {unit::TriangleView(triangles, 0)});
  const auto middle = SceneOf(device, {InstanceOf(inner)});
  const auto outer = SceneOf(device, {InstanceOf(middle)});
  std::size_t hits = 0;
  for (const TimedRay& ray : unit::MakeRays(random, 300)) {
    for (const uint32_t lanes : {1u, 8u}) {
      hits += TraceLanes(*middle, ray, lanes).IsHit();
      ASSERT_FALSE(TraceLanes(*outer, ray, lanes).IsHit()) << lanes << " lanes";
    }
  }
  EXPECT_GT(hits, 100u);
}

/// Counts the rays that are shown with each bit of their masks set.
void CountFullMasks(void* data, const CallbackArguments& arguments) {
  const auto* const masks = static_cast<const uint32_t*>(arguments.packet) +
                            static_cast<std::size_t>(PacketComponent::kMask) * arguments.width;
  auto& count = *static_cast<std::size_t*>(data);
  for (uint32_t lane = 0; lane < arguments.width; ++lane) {
    count += arguments.valid[lane] != 0 && masks[lane] == UINT32_MAX;
  }
}

// What stands in the place of the masks is nobody's then.
TEST(TakeHitTest, FunctionsSeeFullMasksWherePacketsHaveNone) {
  const float vertices[3][3] = {{-9, -9, 1}, {9, -9, 1}, {0, 9, 1}};
  const uint32_t indices[3] = {0, 1, 2};
  std::size_t full = 0;
  Geometry geometry;
  geometry.vertices = {{vertices, 12}};
  geometry.vertex_count = 3;
  geometry.primitives = {indices, 12};
  geometry.primitive_count = 1;
  geometry.closest_filter = {CountFullMasks, &full};
  const auto scene = MakeScene({geometry}, kDefaultBudget);
  unit::Ray ray = unit::MakeRay({0, 0, 0}, {0, 0, 1});
  ray.mask = 5;
  for (int round = 0; round < 3; ++round) {  // the first one splits the scene
    for (const uint32_t lanes : {1u, 8u}) {
      full = 0;
      EXPECT_TRUE(TraceLanes(*scene, ray, lanes, false).IsHit());
      EXPECT_EQ(full, lanes);
    }
  }
}

// A hit at the ray's very end may round to a larger distance, and is one by Embree's test. An
// instance on the way, in which there is nothing to hit, does not change that.
TEST(TakeHitTest, AnInstanceThatIsMissedLeavesARayItsEnd) {
  Random random(9);
  const Model triangles = unit::MakeTriangles(random, 2000);
  // Its box holds everything.
  Model corners;
  corners.steps = {{-4, -4, -4, -4, -3.9f, -4, -3.9f, -4, -4, 4, 4, 4, 4, 3.9f, 4, 3.9f, 4, 4}};
  corners.indices = {0, 1, 2, 3, 4, 5};
  const Geometry mesh = unit::TriangleView(triangles, 1);
  const auto device = std::make_shared<Device>();
  const Geometry instance = InstanceOf(SceneOf(device, {unit::TriangleView(corners, 0)}));
  const auto with = SceneOf(device, {instance, mesh});
  const auto without = SceneOf(device, {mesh});
  std::size_t at_end = 0;
  for (const TimedRay& hit : Trace(*without, unit::MakeRays(random, 1000))) {
    if (!hit.IsHit()) continue;
    unit::Ray ray = unit::MakeRay(hit.org, hit.dir, 0, hit.tfar);
    for (int k = 0; k < 3; ++k, ray.tfar = std::nextafter(ray.tfar, 0.0f)) {
      for (const uint32_t lanes : {1u, 8u}) {
        const FullRay expected = TraceLanes(*without, ray, lanes);
        ASSERT_EQ(TraceLanes(*with, ray, lanes), expected) << lanes << " lanes";
        at_end += expected.IsHit();
      }
    }
  }
  EXPECT_GT(at_end, 500u);
}

// The same through a filter function that accepts everything.
TEST(TakeHitTest, FilterFunctionsAreAskedAboutHitsAtTheEnd) {
  Random random(10);
  const Model triangles = unit::MakeTriangles(random, 2000);
  Geometry geometry = unit::TriangleView(triangles, 0);
  const auto plain = MakeScene({geometry}, kDefaultBudget);
  geometry.closest_filter = {unit::AcceptAll, nullptr};
  const auto asks_last = MakeScene({geometry}, kDefaultBudget);
  const auto asks_at_once = MakeScene({geometry, unit::UserGeometry(1)}, kDefaultBudget);
  std::size_t at_end = 0;
  for (const TimedRay& hit : Trace(*plain, unit::MakeRays(random, 3000))) {
    if (!hit.IsHit()) continue;
    unit::Ray ray = unit::MakeRay(hit.org, hit.dir, 0, hit.tfar);
    for (int k = 0; k < 3; ++k, ray.tfar = std::nextafter(ray.tfar, 0.0f)) {
      for (const uint32_t lanes : {1u, 4u, 8u}) {
        const FullRay expected = TraceLanes(*plain, ray, lanes);
        ASSERT_EQ(TraceLanes(*asks_last, ray, lanes), expected) << lanes << " lanes";
        ASSERT_EQ(TraceLanes(*asks_at_once, ray, lanes), expected) << lanes << " lanes";
        at_end += expected.IsHit();
      }
    }
  }
  EXPECT_GT(at_end, 1000u);
}

// What lies behind a hit that is accepted is no question any more. The triangles of a leaf, the
// farthest first; rays alone, few of a group, lists, and with a mask that not all accept. Groups of
// many, for which that does not hold, are not what a thread begins with.
TEST(TakeHitTest, FilterFunctionsAreAskedAboutNearHitsFirst) {
  Model layers[2];  // in turn, so that a leaf holds both
  for (uint32_t i = 0; i < 4; ++i) {
    Model& model = layers[i % 2];
    model.steps.resize(1);
    const float z = 1 - 1e-4f * static_cast<float>(i);
    model.steps[0].insert(model.steps[0].end(), {-9, -9, z, 9, -9, z, 0, 9, z});
    const uint32_t first = i / 2 * 3;
    model.indices.insert(model.indices.end(), {first, first + 1, first + 2});
  }
  Random random(11);
  Model far_away = unit::MakeTriangles(random, 3000);
  for (float& value : far_away.steps[0]) value -= 100;
  std::size_t asked = 0;
  Geometry geometries[] = {unit::TriangleView(layers[0], 0), unit::TriangleView(layers[1], 1)};
  for (Geometry& geometry : geometries) geometry.closest_filter = {unit::CountAsked, &asked};
  Geometry beside = unit::TriangleView(far_away, 2);
  const auto test = [&](uint32_t mask) {
    beside.mask = mask;
    const auto scene = MakeScene({geometries[0], geometries[1], beside, unit::UserGeometry(3)},
                                 kDefaultBudget, false, 1);
    for (const std::size_t count : {1u, 2u, 3000u}) {
      std::vector<TimedRay> rays(count);
      for (TimedRay& ray : rays) {
        ray.mask = 1;
        ray.org = random.InCube(-0.5f, 0.5f);
        ray.dir = {random.Uniform(-1, 1), random.Uniform(-1, 1), 1};
      }
      for (int round = 0; round < 3; ++round) {  // the first one splits the scene
        asked = 0;
        EXPECT_EQ(unit::CountHits(Trace(*scene, rays)), count);
        EXPECT_EQ(asked, count) << "mask " << mask;
      }
    }
    unit::Ray ray = unit::MakeRay({0, 0, 0}, {0.1f, 0.2f, 1});
    ray.mask = 1;
    asked = 0;
    EXPECT_TRUE(TraceLanes(*scene, ray, 1).IsHit());
    EXPECT_EQ(asked, 1u) << "mask " << mask;
  };
  for (const uint32_t mask : {UINT32_MAX, 2u}) std::thread(test, mask).join();
}

}  // namespace
}  // namespace dacrt
