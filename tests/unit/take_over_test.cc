// Which scenes take over the partition of the one before, what that leaves alone, and what it
// costs.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "film.h"
#include "unit_test.h"

namespace dacrt::unit {
namespace {

TEST(TakeOverTest, AShuffledMeshIsPartitionedAnewUnlessRefitIsForced) {
  Film film(MakeSheets(2, 60));
  film.Check(5000);
  const auto shuffle = [&] {
    Random random(7);
    for (Mesh& mesh : film.meshes) {
      for (std::size_t i = mesh.vertices.size(); i > 1; --i) {
        std::swap(mesh.vertices[i - 1], mesh.vertices[random.Below(static_cast<uint32_t>(i))]);
      }
    }
    for (uint64_t& revision : film.revisions) ++revision;
  };
  shuffle();
  EXPECT_FALSE(film.Advance());
  film.Check(500);
  film = Film(MakeSheets(2, 60));
  film.Check(5000);
  shuffle();
  EXPECT_TRUE(film.Advance({.always_refit = true}));
  film.Check(500);
}

// Arrays in another place have changed, whatever the revision says; so has everything without one.
TEST(TakeOverTest, ArraysInAnotherPlaceHaveChanged) {
  for (const bool has_revision : {true, false}) {
    Film film(MakeSheets(4, 30));
    film.Check(5000);
    if (!has_revision) film.revisions.assign(4, 0);
    std::vector<Float3> moved = film.meshes[1].vertices;
    for (Float3& v : moved) v[2] += 0.1f;
    film.meshes[1].vertices = moved;
    film.meshes[1].vertices.swap(moved);
    ASSERT_TRUE(film.Advance());
    film.Check(2000);
  }
}

TEST(TakeOverTest, WhatCannotBeHitAnyMoreIsLeftOut) {
  Film film(MakeSheets(2, 40));
  film.Check(5000);
  const Float3 before = film.meshes[1].vertices[500];
  film.meshes[1].vertices[500][1] = kNaN;
  ++film.revisions[1];
  EXPECT_FALSE(film.Advance());
  film.Check(2000);
  Wave(film, 1);
  EXPECT_TRUE(film.Advance()) << "those that are left out are the same";
  film.Check(2000);
  film.meshes[1].vertices[500] = before;
  ++film.revisions[1];
  EXPECT_FALSE(film.Advance()) << "there are more again";
  film.Check(2000);
}

TEST(TakeOverTest, AsManyOthersThatAreLeftOutAreNotTheSame) {
  Film film(MakeSheets(2, 40));
  std::vector<Float3>& vertices = film.meshes[1].vertices;
  const float before = vertices[500][1];
  vertices[500][1] = kNaN;
  ++film.revisions[1];
  EXPECT_FALSE(film.Advance());
  film.Check(2000);
  vertices[500][1] = before;
  vertices[800][1] = kNaN;
  ++film.revisions[1];
  EXPECT_FALSE(film.Advance());
  film.Check(2000);
}

// Threads share a large mesh.
TEST(TakeOverTest, EveryPartOfALargeMeshIsLookedAt) {
  Film film(MakeSheets(1, 220));
  std::vector<Float3>& vertices = film.meshes[0].vertices;
  film.Check(2000);
  for (const std::size_t vertex : {std::size_t{100}, vertices.size() / 2, vertices.size() - 1}) {
    const Float3 before = vertices[vertex];
    vertices[vertex][1] = kNaN;
    ++film.revisions[0];
    EXPECT_FALSE(film.Advance()) << vertex;
    film.Check(2000);
    vertices[vertex] = before;
    ++film.revisions[0];
    EXPECT_FALSE(film.Advance()) << "there are more again";
    film.Check(2000);
    Wave(film, static_cast<float>(vertex));
    EXPECT_TRUE(film.Advance());
    film.Check(2000);
  }
}

TEST(TakeOverTest, NothingIsTakenOverFromAnotherDevice) {
  const Mesh mesh = MakeSheets(1, 40)[0];
  const std::vector<Geometry> geometries = {GeometryOf(mesh)};
  const auto device = std::make_shared<Device>(), other = std::make_shared<Device>();
  const Scene scene(device, geometries);
  Random random(1);
  std::vector<Ray> rays = unit::MakeRays(random, 1000, 1);
  scene.Trace(Query::kClosest, unit::ViewOf(rays));
  EXPECT_TRUE(Scene(device, geometries, SceneOptions(), scene).takes_over());
  EXPECT_FALSE(Scene(other, geometries, SceneOptions(), scene).takes_over());
}

// What is looked at vertex by vertex and index by index has any stride.
TEST(TakeOverTest, IndicesThatBecomeIllegalAreLeftOut) {
  for (const std::size_t padding : {0u, 1u}) {
    const Mesh mesh = MakeSheets(1, 40)[0];
    const std::size_t words = 3 + padding;
    std::vector<float> vertices;
    std::vector<uint32_t> indices;
    for (const Float3& v : mesh.vertices) {
      vertices.insert(vertices.end(), v.begin(), v.end());
      vertices.resize(vertices.size() + padding, kNaN);
    }
    for (const auto& triangle : mesh.triangles) {
      indices.insert(indices.end(), triangle.begin(), triangle.end());
      indices.resize(indices.size() + padding, UINT32_MAX);
    }
    Geometry geometry = GeometryOf(mesh);
    geometry.vertices = {{vertices.data(), words * sizeof(float)}};
    geometry.primitives = {indices.data(), words * sizeof(uint32_t)};
    const auto device = std::make_shared<Device>();
    Scene scene(device, std::vector{geometry});
    Random random(11);
    std::vector<Ray> rays = unit::MakeRays(random, 2000, 1);
    scene.Trace(Query::kClosest, unit::ViewOf(rays));
    for (std::size_t i = 2; i < vertices.size(); i += words) vertices[i] += 0.1f;
    Scene moved(device, std::vector{geometry}, SceneOptions{}, scene);
    ASSERT_TRUE(moved.takes_over()) << "what stands between does not count";
    moved.TakeOver(scene);
    moved.Trace(Query::kClosest, unit::ViewOf(rays));
    indices[words * 700 + 1] = static_cast<uint32_t>(mesh.vertices.size());
    const Scene illegal(device, std::vector{geometry}, SceneOptions{}, moved);
    EXPECT_FALSE(illegal.takes_over());
    EXPECT_EQ(illegal.triangle_count(), mesh.triangles.size() - 1);
  }
}

TEST(TakeOverTest, OtherTrianglesArePartitionedAnew) {
  Film film(MakeSheets(2, 40));
  film.Check(5000);
  film.meshes[0].triangles.pop_back();
  ++film.revisions[0];
  EXPECT_FALSE(film.Advance());
  film.Check(2000);
  film.meshes.pop_back();
  film.revisions.pop_back();
  EXPECT_FALSE(film.Advance());
  film.Check(2000);
}

// Nothing is asked for that could be refused: the frame goes on with what there is.
TEST(TakeOverTest, AMonitorThatRefusesAllIsNotAsked) {
  std::atomic<bool> refuses{false};
  std::atomic<int> refused{0};
  const auto device = std::make_shared<Device>(Settings{}, [&](std::ptrdiff_t bytes) {
    refused += refuses && bytes > 0;
    return !refuses;
  });
  std::vector<Mesh> sheets = MakeSheets(2, 60);
  const auto describe = [&](uint64_t revision) {
    std::vector<Geometry> geometries;
    for (const Mesh& mesh : sheets) {
      geometries.push_back(GeometryOf(mesh));
      geometries.back().revision = revision;
    }
    return geometries;
  };
  Scene scene(device, describe(1));
  Random random(5);
  std::vector<Ray> rays = unit::MakeRays(random, 3000, 1), expected = rays, first = rays;
  scene.Trace(Query::kClosest, unit::ViewOf(first));
  for (Mesh& mesh : sheets) {
    for (Float3& v : mesh.vertices) v[2] += 0.03f * v[0];
  }
  refuses = true;
  Scene moved(device, describe(2), SceneOptions{}, scene);
  ASSERT_TRUE(moved.takes_over());
  moved.TakeOver(scene);
  moved.Trace(Query::kClosest, unit::ViewOf(rays));
  EXPECT_EQ(refused, 0);
  refuses = false;
  const Scene fresh(device, describe(2));
  fresh.Trace(Query::kClosest, unit::ViewOf(expected));
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(unit::SameBits(rays[i], expected[i]));
}

// A scene that is not taken over stays as it was.
TEST(TakeOverTest, APlanChangesNothing) {
  std::vector<Mesh> sheets = MakeSheets(2, 50);
  const auto device = std::make_shared<Device>();
  std::vector<Geometry> geometries;
  for (const Mesh& mesh : sheets) geometries.push_back(GeometryOf(mesh));
  const Scene scene(device, geometries, SceneOptions{});
  Random random(3);
  std::vector<Ray> rays = unit::MakeRays(random, 3000, 1), before = rays;
  scene.Trace(Query::kClosest, unit::ViewOf(before));
  std::vector<Mesh> moved = sheets;
  std::vector<Geometry> next;
  for (Mesh& mesh : moved) {
    for (Float3& v : mesh.vertices) v[2] += 0.2f;
    next.push_back(GeometryOf(mesh));
    next.back().primitives = geometries[next.size() - 1].primitives;
  }
  const Scene planned(device, next, SceneOptions{}, scene);
  EXPECT_TRUE(planned.takes_over());
  scene.Trace(Query::kClosest, unit::ViewOf(rays));
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(unit::SameBits(rays[i], before[i]));
}

// For scenes that others show: both are right.
TEST(TakeOverTest, ACopyLeavesTheSceneAsItWas) {
  Film film(MakeSheets(3, 60));
  film.Check(700);  // not all is split, and not all leaves are made
  Random random(9);
  std::vector<Ray> rays = unit::MakeRays(random, 20000, 1), expected = rays;
  const std::vector<Mesh> before = film.meshes;
  std::vector<Geometry> still;
  for (const Mesh& mesh : before) still.push_back(GeometryOf(mesh));
  const Scene fresh(std::make_shared<Device>(), still, SceneOptions{});
  fresh.Trace(Query::kClosest, unit::ViewOf(expected));

  std::vector<std::vector<Float3>> moved;
  for (Mesh& mesh : film.meshes) {
    moved.push_back(mesh.vertices);
    for (Float3& v : moved.back()) v[2] += 0.05f * v[0];
    mesh.vertices.swap(moved.back());  // the scene until now goes on with the old ones
  }
  const std::unique_ptr<Scene> previous = film.Copy();
  film.Check(20000);
  previous->Trace(Query::kClosest, unit::ViewOf(rays));
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(unit::SameBits(rays[i], expected[i]));
}

}  // namespace
}  // namespace dacrt::unit
