// Scene::Trace over kept partitions through the public API: the same bits for every budget, every
// form of call, every number of rays a call and every number of threads, in scenes of all shapes.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

#include "dacrt/dacrt.h"
#include "forms.h"
#include "partition/kept_partition.h"
#include "trace/policy.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::Form;
using unit::FormedRays;
using unit::FullRay;
using unit::kInfinity;
using unit::Mesh;
using unit::Random;
using unit::Ray;
using enum PacketComponent;

constexpr Form kRecords = {1, false, false};

/// A sphere of radius 0.1 around a point for each user primitive; no state but the points.
struct UserSpheres {
  static constexpr float kRadius = 0.1f;

  static void Bound(void* data, uint32_t primitive, uint32_t, Bounds& bounds) {
    const Float3& center = static_cast<const Float3*>(data)[primitive];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.lower[axis] = center[axis] - kRadius;
      bounds.upper[axis] = center[axis] + kRadius;
    }
  }

  static void Intersect(void* data, const CallbackArguments& arguments) {
    const Float3& center = static_cast<const Float3*>(data)[arguments.primitive_id];
    const auto at = [&](PacketComponent component, std::size_t lane) -> float& {
      return static_cast<float*>(
          arguments.packet)[static_cast<std::size_t>(component) * arguments.width + lane];
    };
    for (std::size_t lane = 0; lane < arguments.width; ++lane) {
      if (!arguments.valid[lane]) continue;
      float b = 0, c = 0, d2 = 0;
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const float to = center[axis] - at(static_cast<PacketComponent>(axis), lane);
        const float dir = at(static_cast<PacketComponent>(4 + axis), lane);
        b += to * dir;
        c += to * to;
        d2 += dir * dir;
      }
      b /= d2;
      const float half2 = kRadius * kRadius / d2 - (c / d2 - b * b);
      if (half2 < 0) continue;
      const float t = b - std::sqrt(half2);
      if (t <= at(kTnear, lane) || t < 0 || t > at(kTfar, lane)) continue;
      if (arguments.query == Query::kAny) {
        at(kTfar, lane) = -kInfinity;
        continue;
      }
      at(kTfar, lane) = t;
      const auto put = [&](PacketComponent component, uint32_t value) {
        std::memcpy(&at(component, lane), &value, sizeof(value));
      };
      for (const PacketComponent normal : {kNgX, kNgY, kNgZ}) at(normal, lane) = 1;
      at(kU, lane) = at(kV, lane) = 0;
      put(kPrimitiveId, arguments.primitive_id);
      put(kGeometryId, arguments.geometry_id);
      put(kInstanceId, arguments.instance_id);
    }
  }
};

/// Rejects hits of odd primitives.
void RejectOdd(void*, const CallbackArguments& arguments) {
  const auto* const ids = static_cast<const uint32_t*>(arguments.packet) +
                          static_cast<std::size_t>(kPrimitiveId) * arguments.width;
  for (std::size_t lane = 0; lane < arguments.width; ++lane) {
    if (arguments.valid[lane] && ids[lane] % 2 == 1) arguments.valid[lane] = 0;
  }
}

/// Geometries of every shape, still, moving, masked and with filter functions, side by side.
class World {
 public:
  explicit World(std::size_t scale, uint64_t seed = 1) : scale_(scale), random_(seed) {}

  /// Geometries over arrays of this object, with numbers from `id` on.
  std::vector<Geometry> Make(uint32_t id, bool has_callbacks) {
    std::vector<Geometry> all;
    const auto add = [&](Geometry geometry) -> Geometry& {
      geometry.geometry_id = id++;
      all.push_back(std::move(geometry));
      return all.back();
    };
    add(Facets(Shape::kTriangles, 20 * scale_, 1));
    add(Facets(Shape::kTriangles, 10 * scale_, 1)).mask = 2;
    add(Facets(Shape::kTriangles, 3 * scale_, 3));
    add(Facets(Shape::kQuads, 5 * scale_, 1));
    add(Facets(Shape::kQuads, 2 * scale_, 2)).mask = 6;
    add(scale_ < 10 ? Grid(8, 4) : Grid(40, 12));
    add(Points(Shape::kSpheres, 4 * scale_, 1));
    add(Points(Shape::kDiscs, 4 * scale_, 1));
    add(Points(Shape::kOrientedDiscs, 4 * scale_, 1));
    add(Points(Shape::kSpheres, scale_, 2)).mask = 4;
    if (!has_callbacks) return all;
    Geometry& filtered = add(Facets(Shape::kTriangles, 4 * scale_, 1));
    filtered.closest_filter = filtered.any_filter = {RejectOdd, nullptr};
    Geometry& filtered_points = add(Points(Shape::kSpheres, scale_, 1));
    filtered_points.closest_filter = filtered_points.any_filter = {RejectOdd, nullptr};
    add(Users(scale_));
    return all;
  }

  static Geometry Instance(uint32_t id, std::shared_ptr<const Scene> scene, float x, float turn,
                           bool moves) {
    Geometry geometry;
    geometry.shape = Shape::kInstance;
    geometry.geometry_id = id;
    geometry.primitive_count = 1;
    geometry.instanced_scene = std::move(scene);
    for (int step = 0; step < (moves ? 2 : 1); ++step) {
      TransformStep transform;
      AffineTransform& m = transform.matrix;
      m.column[0][0] = m.column[1][1] = 0.5f * std::cos(turn);
      m.column[0][1] = 0.5f * std::sin(turn);
      m.column[1][0] = -0.5f * std::sin(turn);
      m.column[2][2] = 0.7f;
      m.column[3][0] = x + static_cast<float>(step);
      geometry.transforms.push_back(transform);
    }
    return geometry;
  }

 private:
  const void* Keep(std::vector<float> floats) {
    floats_.push_back(std::make_unique<std::vector<float>>(std::move(floats)));
    return floats_.back()->data();
  }

  Geometry Facets(Shape shape, std::size_t count, std::size_t steps) {
    const std::size_t corners = shape == Shape::kQuads ? 4 : 3;
    std::vector<float> first;
    std::vector<uint32_t> indices;
    for (std::size_t i = 0; i < count; ++i) {
      const Float3 at = random_.InCube(-2, 2), a = random_.InCube(-0.2f, 0.2f),
                   b = random_.InCube(-0.2f, 0.2f);
      for (std::size_t corner = 0; corner < corners; ++corner) {
        const float s = corner == 1 || corner == 2, t = corner >= 2;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          first.push_back(at[axis] + s * a[axis] + t * b[axis]);
        }
        indices.push_back(static_cast<uint32_t>(indices.size()));
      }
    }
    Geometry geometry;
    geometry.shape = shape;
    geometry.vertex_count = first.size() / 3;
    geometry.primitive_count = count;
    for (std::size_t step = 0; step < steps; ++step) {
      std::vector<float> moved = first;
      if (step > 0) {
        for (float& x : moved) x += random_.Uniform(-0.1f, 0.1f);
      }
      geometry.vertices.push_back({Keep(std::move(moved)), 12});
    }
    indices_.push_back(std::make_unique<std::vector<uint32_t>>(std::move(indices)));
    geometry.primitives = {indices_.back()->data(), 4 * corners};
    return geometry;
  }

  Geometry Grid(uint16_t width, uint16_t height) {
    std::vector<float> vertices;
    for (uint16_t y = 0; y < height; ++y) {
      for (uint16_t x = 0; x < width; ++x) {
        const float u = static_cast<float>(x) / static_cast<float>(width - 1);
        const float v = static_cast<float>(y) / static_cast<float>(height - 1);
        vertices.insert(vertices.end(),
                        {4 * u - 2, 4 * v - 2, random_.Uniform(-1.1f, -0.9f)});
      }
    }
    grids_.push_back(std::make_unique<GridPrimitive>(GridPrimitive{0, width, width, height}));
    Geometry geometry;
    geometry.shape = Shape::kGrids;
    geometry.vertex_count = vertices.size() / 3;
    geometry.primitive_count = 1;
    geometry.vertices = {{Keep(std::move(vertices)), 12}};
    geometry.primitives = {grids_.back().get(), sizeof(GridPrimitive)};
    return geometry;
  }

  Geometry Points(Shape shape, std::size_t count, std::size_t steps) {
    Geometry geometry;
    geometry.shape = shape;
    geometry.vertex_count = geometry.primitive_count = count;
    for (std::size_t step = 0; step < steps; ++step) {
      std::vector<float> points, normals;
      for (std::size_t i = 0; i < count; ++i) {
        const Float3 p = random_.InCube(-2, 2), n = random_.Direction();
        points.insert(points.end(), {p[0], p[1], p[2], random_.Uniform(0.01f, 0.1f)});
        normals.insert(normals.end(), n.begin(), n.end());
      }
      geometry.vertices.push_back({Keep(std::move(points)), 16});
      if (shape == Shape::kOrientedDiscs) {
        geometry.normals.push_back({Keep(std::move(normals)), 12});
      }
    }
    return geometry;
  }

  Geometry Users(std::size_t count) {
    std::vector<float> centers;
    for (std::size_t i = 0; i < count; ++i) {
      const Float3 p = random_.InCube(-2, 2);
      centers.insert(centers.end(), p.begin(), p.end());
    }
    Geometry geometry;
    geometry.shape = Shape::kUser;
    geometry.primitive_count = count;
    geometry.bounds = {UserSpheres::Bound, const_cast<void*>(Keep(std::move(centers)))};
    geometry.intersect = geometry.occluded = {UserSpheres::Intersect, geometry.bounds.data};
    return geometry;
  }

  const std::size_t scale_;
  Random random_;
  std::vector<std::unique_ptr<std::vector<float>>> floats_;
  std::vector<std::unique_ptr<std::vector<uint32_t>>> indices_;
  std::vector<std::unique_ptr<GridPrimitive>> grids_;
};

/// A scene and what it is made of: all shapes, and instances of them.
class WorldScene {
 public:
  struct Options {
    bool has_callbacks = true;
    bool has_instances = true;
    bool robust = false;
    Keep keep = Keep::kByBudget;
    bool is_small = false;  ///< not above policy::kSmallScene
  };

  WorldScene(const Settings& settings, const Options& options)
      : world_(options.is_small ? 2 : 40, 1),
        inner_world_(options.is_small ? 2 : 25, 2),
        device_(std::make_shared<Device>(settings)) {
    std::vector<Geometry> geometries = world_.Make(10, options.has_callbacks);
    const SceneOptions scene_options{options.keep, options.robust};
    if (options.has_instances) {
      const std::vector<Geometry> inner = inner_world_.Make(3, options.has_callbacks);
      const auto inner_scene = std::make_shared<Scene>(device_, inner, scene_options);
      // Ids before and behind those of the others.
      geometries.push_back(World::Instance(1, inner_scene, 2, 0.3f, false));
      geometries.push_back(World::Instance(2, inner_scene, -2, 1.3f, true));
      geometries.push_back(World::Instance(50, inner_scene, 0, 2.3f, false));
    }
    scene = std::make_unique<Scene>(device_, geometries, scene_options);
    EXPECT_EQ(scene->triangle_count() <= policy::kSmallScene, options.is_small);
  }

 private:
  World world_;
  World inner_world_;
  std::shared_ptr<Device> device_;

 public:
  std::unique_ptr<Scene> scene;
};

std::vector<FullRay> MakeFullRays(Random& random, std::size_t count) {
  std::vector<FullRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Ray ray = unit::MakeRay(random.InCube(-3, 3), random.Direction());
    if (random.Below(4) == 0) ray.tnear = random.Uniform(-0.5f, 1);
    if (random.Below(4) == 0) ray.tfar = random.Uniform(0.5f, 3);
    if (random.Below(20) == 0) ray.tfar = -1;
    ray.mask = random.Below(3) == 0 ? random.Below(8) : UINT32_MAX;
    rays.push_back(unit::FullRayOf(ray, random.Uniform(0, 1)));
  }
  return rays;
}

std::vector<FullRay> TraceForm(const Scene& scene, const std::vector<FullRay>& rays, Query query,
                               const Form& form = kRecords, const CallOptions& options = {}) {
  FormedRays formed(rays, form);
  scene.Trace(query, formed.View(), options);
  EXPECT_TRUE(formed.GuardsHold());
  return formed.Rays();
}

/// In calls of `count` rays.
std::vector<FullRay> TraceInCalls(const Scene& scene, const std::vector<FullRay>& rays,
                                  Query query, std::size_t count) {
  std::vector<FullRay> all;
  for (std::size_t i = 0; i < rays.size(); i += count) {
    const auto end = rays.begin() + static_cast<std::ptrdiff_t>(std::min(i + count, rays.size()));
    const auto some =
        TraceForm(scene, {rays.begin() + static_cast<std::ptrdiff_t>(i), end}, query);
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

/// In packets of `lanes` lanes, of which those that `valid` says take part.
std::vector<FullRay> TracePackets(const Scene& scene, const std::vector<FullRay>& rays,
                                  Query query, uint32_t lanes, const std::vector<int32_t>* valid,
                                  bool has_masks = true) {
  FormedRays formed(rays, {lanes, false, false});
  const RayView view = formed.View();
  for (std::size_t i = 0; i < rays.size(); i += lanes) {
    RayPacket packet;
    packet.values = reinterpret_cast<void*>(view.Address(view.org_x, i));
    packet.lanes = lanes;
    packet.has_masks = has_masks;
    std::vector<int32_t> own(lanes, 0);  // lanes behind the last ray
    for (uint32_t lane = 0; lane < lanes && i + lane < rays.size(); ++lane) {
      own[lane] = valid ? (*valid)[i + lane] : -1;
    }
    if (valid || i + lanes > rays.size()) packet.valid = own.data();
    scene.Trace(query, packet);
  }
  EXPECT_TRUE(formed.GuardsHold());
  return formed.Rays();
}

void ExpectSame(const std::vector<FullRay>& actual, const std::vector<FullRay>& expected,
                const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    const auto text = [](const FullRay& ray) {
      return "t " + std::to_string(ray.Get(kTfar)) + " instance " +
             std::to_string(ray.Get<uint32_t>(kInstanceId)) + " geometry " +
             std::to_string(ray.Get<uint32_t>(kGeometryId)) + " primitive " +
             std::to_string(ray.Get<uint32_t>(kPrimitiveId)) + " u " + std::to_string(ray.Get(kU));
    };
    ASSERT_TRUE(actual[i] == expected[i])
        << what << ": ray " << i << ": " << text(actual[i]) << ", expected " << text(expected[i]);
  }
}

class KeptTraceTest : public testing::TestWithParam<InstructionSet> {
 protected:
  Settings WithBudget(uint64_t budget, uint32_t threads = 1) const {
    Settings settings;
    settings.instruction_set = GetParam();
    settings.budget = budget;
    settings.threads = threads;
    return settings;
  }

  std::unique_ptr<Scene> MakeScene(const Mesh& mesh, const Settings& settings) const {
    const TriangleMesh view = mesh.View();
    return std::make_unique<Scene>(std::make_shared<Device>(settings), std::span(&view, 1));
  }
};

INSTANTIATE_TEST_SUITE_P(InstructionSets, KeptTraceTest,
                         testing::ValuesIn(AvailableInstructionSets()),
                         [](const auto& info) { return std::string(Name(info.param)); });

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
    EXPECT_GE(geometries.size(), options.is_small ? 5u : 10u);
    EXPECT_EQ(instances.size(), options.has_instances ? 4u : 1u);
    for (const uint64_t budget : kBudgets) {
      for (const Keep keep : {Keep::kByBudget, Keep::kLittle}) {
        if (keep == Keep::kLittle && budget != kDefaultBudget) continue;
        options.keep = keep;
        const std::string what = "kind " + std::to_string(kind) + ", budget " +
                                 std::to_string(budget) +
                                 (keep == Keep::kLittle ? ", little" : "");
        const WorldScene world(WithBudget(budget, 2), options);
        const Scene& scene = *world.scene;
        ASSERT_EQ(scene.KeptBytes() > 0, budget > 0);
        ExpectSame(TraceForm(scene, rays, Query::kClosest), expected, what);
        ExpectSame(TraceForm(scene, rays, Query::kAny), expected_any, what + ", any");
        if (budget > 0) ASSERT_LE(scene.KeptBytesUsed(), scene.KeptBytes());
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
        for (const Form& form : unit::AllForms()) {
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
      const std::vector<FullRay> rays(
          lanes, unit::FullRayOf(unit::MakeRay({0, 0, 0}, {1, 0, 0})));
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
  const FullRay before = unit::FullRayOf(unit::MakeRay({0, 0, 0}, {1, 0, 0}));
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

// --- Deep and degenerate partitions --------------------------------------------------------------

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
    rays.push_back(unit::FullRayOf(unit::MakeRay(org, dir)));
  }
  return rays;
}

// Sizes and distances in a geometric series: nodes peel off a few triangles at a time, and a ray
// from the middle enters every one of them.
TEST_P(KeptTraceTest, ExponentialSeries) {
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
TEST_P(KeptTraceTest, TrianglesThatCoincide) {
  Random random(8);
  Mesh mesh;
  for (int i = 0; i < 40; ++i) {
    const Float3 a = random.InCube(-1, 1), b = random.InCube(-1, 1), c = random.InCube(-1, 1);
    for (int copy = 0; copy < 1 + i % 12; ++copy) mesh.Add(a, b, c);
  }
  std::vector<FullRay> rays;
  for (int i = 0; i < 300; ++i) {
    rays.push_back(unit::FullRayOf(unit::MakeRay(random.InCube(-2, 2), random.Direction())));
  }
  ExpectBruteForce(mesh, rays, WithBudget(0), "copies");
}

// Large numbers of them: the smallest name, whatever stands where in the order.
TEST_P(KeptTraceTest, ThousandsThatCoincide) {
  Mesh mesh;
  mesh.vertices = {{1, -1, -1}, {1, 1, -1}, {1, 0, 1}};
  mesh.triangles.assign(5000, {0, 1, 2});
  const std::vector<FullRay> rays(60, unit::FullRayOf(unit::MakeRay({0, 0, 0}, {1, 0, 0})));
  for (const uint64_t budget : {uint64_t{1}, uint64_t{8 * 5000}, kUnlimitedBudget}) {
    const auto scene = MakeScene(mesh, WithBudget(budget));
    for (const auto& found :
         {TraceForm(*scene, rays, Query::kClosest), TraceInCalls(*scene, rays, Query::kClosest, 50),
          TracePackets(*scene, {rays[0]}, Query::kClosest, 1, nullptr)}) {
      for (const FullRay& ray : found) {
        ASSERT_EQ(ray.Get(kTfar), 1);
        ASSERT_EQ(ray.Get<uint32_t>(kPrimitiveId), 0u);
      }
    }
  }
}

// Slivers and points, all through one point.
TEST_P(KeptTraceTest, SliversThroughOnePoint) {
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
    rays.push_back(unit::FullRayOf(unit::MakeRay(random.InCube(-1, 1), random.Direction())));
  }
  ExpectBruteForce(mesh, rays, WithBudget(0), "slivers");
}

// --- Callbacks that trace ------------------------------------------------------------------------

// A filter function that traces rays of its own through the same fresh scene, which has subsets to
// split and leaves to fill in on the way.
TEST_P(KeptTraceTest, CallbacksMayTraceTheSameScene) {
  Random random(10);
  const Mesh mesh = unit::MakeSoup(random, 6000, 1, 0.1f);
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
  for (const uint64_t budget : {uint64_t{0}, uint64_t{1}, uint64_t{60000}, kDefaultBudget}) {
    for (const bool is_short : {false, true}) {
      Inner inner;
      Geometry geometry;
      geometry.vertices = {{mesh.vertices.data(), 12}};
      geometry.vertex_count = mesh.vertices.size();
      geometry.primitives = {mesh.triangles.data(), 12};
      geometry.primitive_count = mesh.triangles.size();
      geometry.closest_filter = {Inner::Filter, &inner};
      const Scene scene(std::make_shared<Device>(WithBudget(budget)), {&geometry, 1},
                        SceneOptions{});
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
      EXPECT_GT(inner.calls, 10u);
      EXPECT_EQ(inner.wrong, 0u) << "budget " << budget;
    }
  }
}

// --- What is kept ----------------------------------------------------------------------------------

TEST_P(KeptTraceTest, BudgetsAreKept) {
  Random random(11);
  constexpr std::size_t kTriangles = 30000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.03f);
  const TriangleMesh view = mesh.View();
  auto rays = unit::MakeRays(random, 40000, 1);
  const std::size_t least = KeptPartition::LeastBytes(kTriangles);
  struct Case {
    uint64_t budget;
    Keep keep;
    std::size_t most;
  };
  const Case cases[] = {{kDefaultBudget, Keep::kByBudget, 32 * kTriangles},
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
}  // namespace dacrt
