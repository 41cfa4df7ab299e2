// What tests of Scene::Trace share: a scene with its meshes, rays of all kinds, and settings that
// may not change a hit.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "instruction_sets.h"
#include "partition/kept_partition.h"
#include "unit_test.h"

namespace dacrt::unit {

/// A scene with its device and its meshes.
class TestScene {
 public:
  TestScene(std::vector<Mesh> meshes, const Settings& settings)
      : meshes_(std::move(meshes)), scene_(std::make_shared<Device>(settings), Views(meshes_)) {}

  Statistics Trace(std::vector<Ray>& rays, Query query = Query::kClosest) const {
    return scene_.Trace(query, ViewOf(rays));
  }

  std::vector<Ray> Traced(std::vector<Ray> rays, Query query = Query::kClosest) const {
    Trace(rays, query);
    return rays;
  }

  const Scene& operator*() const { return scene_; }

 private:
  std::vector<Mesh> meshes_;
  Scene scene_;
};

inline void ExpectSameRays(const std::vector<Ray>& actual, const std::vector<Ray>& expected,
                           const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_TRUE(SameBits(actual[i], expected[i]))
        << what << ": ray " << i << ": t " << std::hexfloat << actual[i].tfar << " primitive "
        << actual[i].primitive_id << ", expected " << expected[i].tfar << " primitive "
        << expected[i].primitive_id;
  }
}

/// Blocked rays are those that have a closest hit; nothing but tfar is written.
inline void ExpectBlockedWhereHit(const std::vector<Ray>& blocked, const std::vector<Ray>& before,
                                  const std::vector<Ray>& closest) {
  for (std::size_t i = 0; i < blocked.size(); ++i) {
    Ray expected = before[i];
    if (closest[i].IsHit()) expected.tfar = -kInfinity;
    ASSERT_TRUE(SameBits(blocked[i], expected)) << "ray " << i;
  }
}

/// Several meshes of different density, with a shared wall and triangles that coincide.
inline std::vector<Mesh> MakeMeshes(Random& random) {
  std::vector<Mesh> meshes = {MakeSoup(random, 600, 2, 0.4f), MakeSoup(random, 300, 0.3f, 0.1f),
                              Mesh()};
  meshes[0].geometry_id = 5;
  meshes[1].geometry_id = 2;
  meshes[2].geometry_id = 9;
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      const float x = static_cast<float>(i) * 0.4f - 2, z = static_cast<float>(j) * 0.4f - 2;
      meshes[2].Add({x, -1, z}, {x + 0.4f, -1, z}, {x, -1, z + 0.4f});
      meshes[2].Add({x + 0.4f, -1, z}, {x + 0.4f, -1, z + 0.4f}, {x, -1, z + 0.4f});
      meshes[2].Add({x, -1, z}, {x + 0.4f, -1, z}, {x, -1, z + 0.4f});  // once more
    }
  }
  return meshes;
}

/// Rays of every kind: from inside and outside, ended and unbounded, along the axes, in the wall's
/// plane, through its vertices, inactive.
inline std::vector<Ray> MakeMixedRays(Random& random, std::size_t count) {
  std::vector<Ray> rays = MakeRays(random, count, 3);
  for (std::size_t i = 0; i < count; ++i) {
    Ray& ray = rays[i];
    switch (i % 8) {
      case 1:
        ray.tfar = random.Uniform(0, 4);
        break;
      case 2:
        ray.tnear = random.Uniform(-1, 2);
        break;
      case 3:
        ray.dir = {0, 0, 0};
        ray.dir[random.Below(3)] = random.Next() & 1 ? 1.0f : -1.0f;
        break;
      case 4:  // down on a vertex of the wall
        ray.org = {static_cast<float>(random.Below(10)) * 0.4f - 2, 3,
                   static_cast<float>(random.Below(10)) * 0.4f - 2};
        ray.dir = {0, -1, -0.0f};
        break;
      case 5:  // in the wall's plane
        ray.org[1] = -1;
        ray.dir[1] = 0;
        break;
      case 6:
        if (i % 16 == 6) ray.tfar = -1;
        break;
      case 7:  // a camera
        ray.org = {0, 1, 3};
        ray.dir = {random.Uniform(-1, 1), random.Uniform(-1, 1), -1};
        break;
      default:
        break;
    }
  }
  return rays;
}

/// Ray i of a camera that scans a narrow field line by line.
inline void AimAsACamera(Ray& ray, std::size_t i) {
  ray.org = {0, 0.5f, 6};
  ray.dir = {static_cast<float>(i % 50) * 0.004f - 0.1f, static_cast<float>(i / 50) * 0.006f - 0.1f,
             -1};
}

/// As AimAsACamera, of so fine a picture that consecutive rays make narrow packets.
inline void AimAsAFineCamera(Ray& ray, std::size_t i) {
  ray.org = {0, 0.5f, 6};
  ray.dir = {static_cast<float>(i % 64) * 0.002f - 0.064f,
             static_cast<float>(i / 64) * 0.004f - 0.1f, -1};
}

/// Settings that change everything that may not change a hit.
inline std::vector<Settings> VariedSettings() {
  std::vector<Settings> all;
  const auto add = [&](auto&& change) {
    Settings settings;
    settings.sample_threshold = 50;  // small enough that batches of a test are sampled
    settings.budget = 0;             // else most settings would have nothing to do
    change(settings);
    all.push_back(settings);
  };
  add([](Settings&) {});
  add([](Settings& s) { s.bins = 2; });
  add([](Settings& s) { s.bins = 32; });
  add([](Settings& s) { s.leaf_triangles = 1; });
  add([](Settings& s) { s.leaf_triangles = 64; });
  add([](Settings& s) { s.leaf_rays = 1; });
  add([](Settings& s) { s.leaf_rays = 1024; });
  add([](Settings& s) { s.piece_rays = 64; });
  add([](Settings& s) { s.piece_rays = 333; });
  add([](Settings& s) { s.sample_rays = 1; });
  add([](Settings& s) { s.sample_rays = 1024; });
  add([](Settings& s) { s.sample_threshold = 1; });
  add([](Settings& s) { s.sample_threshold = UINT32_MAX; });
  add([](Settings& s) { s.sampled_cost = false; });
  add([](Settings& s) { s.sampled_order = false; });
  add([](Settings& s) { s.skip_filtering = false; });
  add([](Settings& s) { s.algorithm = Algorithm::kAfra2012; });
  add([](Settings& s) { s.algorithm = Algorithm::kMora2011; });
  add([](Settings& s) {
    s.algorithm = Algorithm::kMora2011;
    s.bins = 2;
    s.leaf_triangles = 1;
    s.leaf_rays = 1;
  });
  add([](Settings& s) {
    s.bins = 2;
    s.leaf_triangles = 1;
    s.leaf_rays = 1;
    s.sample_rays = 1;
    s.sample_threshold = 1;
    s.piece_rays = 64;
  });
  // A kept partition, also one with hardly any room for nodes.
  for (const uint64_t budget : {kDefaultBudget, uint64_t{10000}}) {
    for (const uint32_t threads : {1u, 3u}) {
      add([&](Settings& s) {
        s.budget = budget;
        s.threads = threads;
      });
    }
    add([&](Settings& s) {
      s.budget = budget;
      s.piece_rays = 64;
      s.threads = 2;
    });
  }
  return all;
}

/// One scene for many settings: a soup that needs a grid and several levels of subsets, and in it a
/// dense cluster.
inline std::vector<Mesh> MakeLargeMeshes(Random& random) {
  std::vector<Mesh> meshes = {MakeSoup(random, 14000, 2, 0.12f),
                              MakeSoup(random, 6000, 0.05f, 0.004f)};
  meshes[0].geometry_id = 4;
  meshes[1].geometry_id = 1;
  return meshes;
}

/// What a partition may have, from hardly anything to more than it takes.
inline std::vector<uint64_t> VariedBudgets(std::size_t triangles) {
  return {KeptPartition::LeastBytes(triangles), 5 * triangles, kDefaultBudget, kUnlimitedBudget};
}

class TraceTest : public OnEachInstructionSet {};

}  // namespace dacrt::unit
