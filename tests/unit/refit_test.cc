// Scenes that come in the place of others: the same bits as a scene that is made anew, whatever has
// moved, and a partition that is taken over where it fits.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "dacrt/dacrt.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::kNaN;
using unit::Mesh;
using unit::Random;
using unit::Ray;

/// Some hilly sheets in [-1, 1]^3, one above the other.
std::vector<Mesh> MakeSheets(uint32_t count, uint32_t side) {
  std::vector<Mesh> sheets(count);
  for (uint32_t i = 0; i < count; ++i) {
    Mesh& mesh = sheets[i];
    mesh.geometry_id = 3 * i;
    for (uint32_t y = 0; y <= side; ++y) {
      for (uint32_t x = 0; x <= side; ++x) {
        const float u = 2.0f * x / side - 1, v = 2.0f * y / side - 1;
        const float height = 0.1f * std::sin(9 * u) * std::cos(7 * v);
        mesh.vertices.push_back({u, v, height + 2.0f * (i + 1) / (count + 1) - 1});
      }
    }
    const uint32_t row = side + 1;
    for (uint32_t y = 0; y < side; ++y) {
      for (uint32_t x = 0; x < side; ++x) {
        const uint32_t v = y * row + x;
        mesh.triangles.push_back({v, v + 1, v + row});
        mesh.triangles.push_back({v + row + 1, v + row, v + 1});
      }
    }
  }
  return sheets;
}

Geometry GeometryOf(const Mesh& mesh) {
  Geometry geometry;
  geometry.geometry_id = mesh.geometry_id;
  geometry.mask = mesh.mask;
  geometry.vertices = {{mesh.vertices.data(), sizeof(Float3)}};
  geometry.vertex_count = mesh.vertices.size();
  geometry.primitives = {mesh.triangles.data(), 3 * sizeof(uint32_t)};
  geometry.primitive_count = mesh.triangles.size();
  return geometry;
}

/// A scene from frame to frame.
class Film {
 public:
  explicit Film(std::vector<Mesh> sheets, std::size_t threads = 1)
      : meshes(std::move(sheets)), revisions(meshes.size(), 1), hidden(meshes.size()) {
    Settings settings;
    settings.threads = threads;
    device_ = std::make_shared<Device>(settings);
    scene_ = std::make_unique<Scene>(device_, Geometries(), SceneOptions{});
  }

  /// The next frame. Returns whether it took over the partition of the one before.
  bool Advance(const SceneOptions& options = {}) {
    auto next = std::make_unique<Scene>(device_, Geometries(), options, *scene_);
    const bool takes_over = next->takes_over();
    next->TakeOver(*scene_);
    EXPECT_FALSE(next->takes_over());
    scene_ = std::move(next);
    return takes_over;
  }

  /// The next frame, in which one mesh has moved or has another mask, without another scene. False
  /// if that would not do.
  bool Update(std::size_t mesh) { return scene_->Update({Describe(mesh)}); }
  bool Hide(std::size_t mesh) {
    hidden[mesh] = true;
    Geometry description;
    description.geometry_id = meshes[mesh].geometry_id;
    description.hidden = true;
    return scene_->Update({description});
  }

  /// Goes on with a copy of the partition; returns the scene that has had it until now.
  std::unique_ptr<Scene> Copy() {
    auto next = std::make_unique<Scene>(device_, Geometries(), SceneOptions{}, *scene_);
    EXPECT_TRUE(next->takes_over());
    next->TakeCopy(*scene_);
    EXPECT_FALSE(next->takes_over());
    scene_.swap(next);
    return next;
  }

  /// Compares the hits of rays with those of a scene that is made anew.
  void Check(std::size_t count) const {
    Random random(count);
    std::vector<Ray> rays = unit::MakeRays(random, count, 1.2f);
    std::vector<Ray> expected = rays;
    const Scene fresh(device_, Geometries(), SceneOptions{});
    fresh.Trace(Query::kClosest, unit::ViewOf(expected));
    scene_->Trace(Query::kClosest, unit::ViewOf(rays));
    std::size_t hits = 0;
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(unit::SameBits(rays[i], expected[i])) << "ray " << i;
      hits += rays[i].IsHit();
    }
    if (count >= 50) {
      EXPECT_GT(hits, 0u);
    }
    const Bounds own = scene_->bounds(), bounds = fresh.bounds();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(own.lower[axis], bounds.lower[axis]);
      EXPECT_EQ(own.upper[axis], bounds.upper[axis]);
    }
    if (std::ranges::none_of(hidden, std::identity())) {
      EXPECT_EQ(scene_->triangle_count(), fresh.triangle_count());
    }
  }

  void ForEachVertex(const std::function<void(Float3&)>& move) {
    for (Mesh& mesh : meshes) std::for_each(mesh.vertices.begin(), mesh.vertices.end(), move);
    for (uint64_t& revision : revisions) ++revision;
  }

  Scene& scene() { return *scene_; }

  std::vector<Mesh> meshes;
  std::vector<uint64_t> revisions;
  std::vector<bool> hidden;  ///< which meshes are

 private:
  Geometry Describe(std::size_t mesh) const {
    Geometry geometry = GeometryOf(meshes[mesh]);
    geometry.revision = revisions[mesh];
    return geometry;
  }

  std::vector<Geometry> Geometries() const {
    std::vector<Geometry> geometries;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      if (!hidden[i]) geometries.push_back(Describe(i));
    }
    return geometries;
  }

  std::shared_ptr<Device> device_;
  std::unique_ptr<Scene> scene_;
};

void Wave(Film& film, float phase) {
  film.ForEachVertex([=](Float3& v) { v[2] += 0.01f * std::sin(phase + 4 * v[0]); });
}

// Few and many triangles, before and after all has been split, with calls of every length.
TEST(RefitTest, AWavingMeshIsTakenOverAndHasTheSameHits) {
  for (const uint32_t side : {4u, 30u, 90u}) {
    Film film(MakeSheets(3, side));
    film.Check(50);
    for (int frame = 0; frame < 6; ++frame) {
      SCOPED_TRACE("side " + std::to_string(side) + ", frame " + std::to_string(frame));
      Wave(film, static_cast<float>(frame));
      ASSERT_TRUE(film.Advance());
      film.Check(std::size_t{1} << (2 * frame));
      if (frame == 3) film.Check(20000);
    }
  }
}

TEST(RefitTest, ThreadsThatComeAtOnceFindTheSameHits) {
  Film film(MakeSheets(2, 100), 4);
  film.Check(5000);
  for (int frame = 0; frame < 10; ++frame) {
    Wave(film, static_cast<float>(frame));
    ASSERT_TRUE(film.Advance());
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) threads.emplace_back([&] { film.Check(3000); });
    for (std::thread& thread : threads) thread.join();
  }
}

TEST(RefitTest, AShearedMeshIsTakenOver) {
  Film film(MakeSheets(2, 60));
  film.Check(5000);
  film.ForEachVertex([](Float3& v) { v[0] += 0.2f * v[1]; });
  EXPECT_TRUE(film.Advance());
  film.Check(5000);
  for (int frame = 0; frame < 20; ++frame) {
    film.ForEachVertex([](Float3& v) { v[0] += 0.3f * v[1], v[2] += 0.3f * v[0]; });
    film.Advance();
    film.Check(1000);
  }
}

// Every triangle for itself, so that corners which leaves had once come apart.
TEST(RefitTest, AnExplodedMeshHasTheSameHits) {
  std::vector<Mesh> sheets = MakeSheets(2, 60);
  for (Mesh& mesh : sheets) {
    Mesh torn;
    torn.geometry_id = mesh.geometry_id;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      torn.Add(mesh.Corner(i, 0), mesh.Corner(i, 1), mesh.Corner(i, 2));
    }
    mesh = torn;
  }
  Film film(sheets);
  film.Check(5000);
  for (int frame = 0; frame < 8; ++frame) {
    Random random(1);
    for (Mesh& mesh : film.meshes) {
      for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
        const Float3 away = random.Direction();
        for (std::size_t k = i; k < i + 3; ++k) {
          for (std::size_t axis = 0; axis < 3; ++axis) mesh.vertices[k][axis] += 0.02f * away[axis];
        }
      }
    }
    for (uint64_t& revision : film.revisions) ++revision;
    film.Advance();
    film.Check(3000);
  }
}

TEST(RefitTest, AShuffledMeshIsPartitionedAnewUnlessRefitIsForced) {
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

TEST(RefitTest, OneMeshOfMany) {
  Film film(MakeSheets(80, 8));
  film.Check(5000);
  for (std::size_t frame = 0; frame < 8; ++frame) {
    Mesh& mesh = film.meshes[37 * frame % film.meshes.size()];
    for (Float3& v : mesh.vertices) v[2] -= 0.02f;
    ++film.revisions[37 * frame % film.meshes.size()];
    ASSERT_TRUE(film.Advance());
    film.Check(2000);
  }
}

TEST(RefitTest, OneMeshOfManyIsUpdatedInItsPlace) {
  Film film(MakeSheets(80, 8));
  EXPECT_FALSE(film.Update(0)) << "nothing is split that could be kept";
  film.Check(5000);
  for (std::size_t frame = 0; frame < 8; ++frame) {
    const std::size_t i = 37 * frame % film.meshes.size();
    std::vector<Float3> moved = film.meshes[i].vertices;
    for (Float3& v : moved) v[2] -= 0.02f;
    if (frame % 2 == 0) {
      film.meshes[i].vertices = moved;
      ++film.revisions[i];
    } else {
      film.meshes[i].vertices.swap(moved);  // another place says that it has changed
    }
    if (frame == 4) film.meshes[i].mask = 0;
    if (frame == 6) film.meshes[37 * 4 % film.meshes.size()].mask = UINT32_MAX;
    ASSERT_TRUE(film.Update(i));
    if (frame == 6) {
      ASSERT_TRUE(film.Update(37 * 4 % film.meshes.size()));
    }
    film.Check(2000);
  }
}

// Each asks for another scene; this one is then still what it was.
TEST(RefitTest, AnUpdateThatWouldNotDoChangesNothing) {
  Film film(MakeSheets(3, 40));
  film.Check(5000);
  const std::vector<Mesh> sheets = film.meshes;
  const auto refuses = [&](const char* what, const Mesh& mesh) {
    SCOPED_TRACE(what);
    std::vector<Mesh> others = sheets;
    for (Float3& v : others[2].vertices) v[2] += 0.1f;
    EXPECT_FALSE(film.scene().Update({GeometryOf(others[2]), GeometryOf(mesh)}));
    film.Check(3000);
  };
  Mesh other = sheets[1];
  other.triangles.pop_back();
  refuses("another number of triangles", other);
  other = sheets[1];
  refuses("indices in another place", other);
  other.geometry_id = 77;
  refuses("an ID that there is not", other);

  Geometry description = GeometryOf(film.meshes[1]);
  std::vector<Float3> spoilt = film.meshes[1].vertices;
  for (Float3& v : spoilt) v[0] += 3;
  spoilt[5][0] = kNaN;
  const float upper = film.scene().linear_bounds().begin.upper[0];
  description.vertices = {{spoilt.data(), sizeof(Float3)}};
  EXPECT_FALSE(film.scene().Update({description})) << "other triangles can be hit";
  EXPECT_EQ(film.scene().linear_bounds().begin.upper[0], upper) << "reads the arrays";
  film.Check(3000);
  description.vertices[0].stride = 13;
  EXPECT_THROW(film.scene().Update({description}), Error);
  film.Check(3000);
  description = GeometryOf(film.meshes[1]);
  description.closest_filter.function = [](void*, const CallbackArguments&) {};
  EXPECT_FALSE(film.scene().Update({description})) << "a filter function";
  film.Check(3000);
}

// They leave volumes and leaves, whether they filled them alone or not, and come back as they are
// by then.
TEST(RefitTest, HiddenMeshesAreNotThereAndComeBack) {
  for (const std::size_t rays : {300u, 20000u}) {  // hardly anything is split, or all
    Film film(MakeSheets(60, 10));
    film.Check(rays);
    for (std::size_t i = 0; i < 60; i += 20) ASSERT_TRUE(film.Hide(i));
    ASSERT_TRUE(film.Hide(0)) << "it is";
    film.Check(rays);
    for (std::size_t i = 20; i < 60; i += 20) {
      // What is hidden is not read: this one lies elsewhere by now.
      for (Float3& v : film.meshes[i].vertices) v[2] += 0.02f;
      ++film.revisions[i];
      film.hidden[i] = false;
      ASSERT_TRUE(film.Update(i));
    }
    film.Check(rays);
    for (Float3& v : film.meshes[3].vertices) v[2] -= 0.02f;
    ++film.revisions[3];
    ASSERT_TRUE(film.Update(3)) << "beside hidden ones";
    film.Check(rays);
    EXPECT_FALSE(film.Advance()) << "other geometries";
    film.Check(rays);
  }
}

// In scenes of every size: leaves of small ones are prepared.
TEST(RefitTest, HiddenMeshesOfSmallScenes) {
  for (const uint32_t side : {1u, 3u, 12u}) {
    Film film(MakeSheets(4, side));
    film.Check(3000);
    for (const std::size_t i : {0u, 2u, 3u}) {
      ASSERT_TRUE(film.Hide(i));
      film.Check(3000);
    }
    film.hidden[2] = false;
    ASSERT_TRUE(film.Update(2));
    film.Check(3000);
  }
}

TEST(RefitTest, AllMeshesMayBeHidden) {
  Film film(MakeSheets(3, 40));
  film.Check(5000);
  for (const std::size_t i : {1u, 0u, 2u}) {
    ASSERT_TRUE(film.Hide(i));
    if (i != 2) film.Check(5000);
  }
  Random random(4);
  std::vector<Ray> rays = unit::MakeRays(random, 3000, 1);
  const std::vector<Ray> before = rays;
  film.scene().Trace(Query::kClosest, unit::ViewOf(rays));
  for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(unit::SameBits(rays[i], before[i]));
  EXPECT_GT(film.scene().bounds().lower[0], film.scene().bounds().upper[0]);
  for (const std::size_t i : {2u, 0u, 1u}) {
    film.hidden[i] = false;
    ASSERT_TRUE(film.Update(i));
    film.Check(5000);
  }
}

// For scenes that others show: both are right.
TEST(RefitTest, ACopyLeavesTheSceneAsItWas) {
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

// Arrays in another place have changed, whatever the revision says; so has everything without one.
TEST(RefitTest, ArraysInAnotherPlaceHaveChanged) {
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

TEST(RefitTest, WhatCannotBeHitAnyMoreIsLeftOut) {
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

// What is looked at vertex by vertex and index by index has any stride.
TEST(RefitTest, IndicesThatBecomeIllegalAreLeftOut) {
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

TEST(RefitTest, OtherTrianglesArePartitionedAnew) {
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

// Indices that change in place: the subsets hold the same triangles, wherever they are now.
TEST(RefitTest, IndicesThatChangeInPlaceHaveTheSameHits) {
  Film film(MakeSheets(1, 40));
  film.Check(5000);
  for (auto& triangle : film.meshes[0].triangles) std::swap(triangle[0], triangle[2]);
  for (std::size_t i = 0; i + 1 < 600; i += 2) {
    std::swap(film.meshes[0].triangles[i], film.meshes[0].triangles[i + 1]);
  }
  ++film.revisions[0];
  film.Advance();
  film.Check(2000);
}

// However often corners come apart, the memory stays what it was.
TEST(RefitTest, WhatIsLostComesBackWithANewPartition) {
  Film film(MakeSheets(1, 80));
  film.Check(20000);
  bool is_renewed = false;
  for (uint32_t frame = 0; frame < 60; ++frame) {
    Random random(frame);
    for (auto& triangle : film.meshes[0].triangles) {
      std::rotate(triangle.begin(), triangle.begin() + random.Below(3), triangle.end());
    }
    for (Float3& v : film.meshes[0].vertices) v[2] += random.Uniform(-0.01f, 0.01f);
    ++film.revisions[0];
    const std::size_t bytes = film.scene().KeptBytes();
    is_renewed |= !film.Advance();
    EXPECT_EQ(film.scene().KeptBytes(), bytes);
    film.Check(3000);
    EXPECT_LE(film.scene().KeptBytesUsed(), bytes);
  }
  (void)is_renewed;
}

// Nothing is asked for that could be refused: the frame goes on with what there is.
TEST(RefitTest, AMonitorThatRefusesAllIsNotAsked) {
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
TEST(RefitTest, APlanChangesNothing) {
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

}  // namespace
}  // namespace dacrt
