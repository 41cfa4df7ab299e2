// Geometries that are attached behind those of a scene: the partition gets a subset more, and
// nothing that it has is split again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "film.h"
#include "shape_scenes.h"
#include "unit_test.h"

namespace dacrt::unit {
namespace {

/// Sheets from front to back, of which a film begins with some.
class Sheets {
 public:
  Sheets(uint32_t count, uint32_t side) : all_(MakeSheets(count, side)) {
    // Each in a place of its own, so that they come anywhere.
    Random random(count);
    for (Mesh& mesh : all_) {
      const Float3 at = random.InCube(-1, 1);
      for (Float3& v : mesh.vertices) {
        for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = 0.3f * v[axis] + at[axis];
      }
    }
  }

  Film Begin(std::size_t count, std::size_t threads = 1) {
    next_ = count;
    return Film({all_.begin(), all_.begin() + static_cast<std::ptrdiff_t>(count)}, threads);
  }

  /// Appends the next ones.
  void Attach(Film& film, std::size_t count = 1) {
    for (; count > 0; --count) {
      film.meshes.push_back(all_.at(next_++));
      film.revisions.push_back(1);
      film.hidden.push_back(false);
    }
  }

 private:
  std::vector<Mesh> all_;
  std::size_t next_ = 0;
};

TEST(GrowthTest, AnAttachedMeshIsASubsetMore) {
  Sheets sheets(65, 12);
  Film film = sheets.Begin(60);
  film.Check(20000);
  const std::size_t used = film.scene().KeptBytesUsed(), bytes = film.scene().KeptBytes();
  sheets.Attach(film);
  ASSERT_TRUE(film.Advance());
  constexpr std::size_t kOrder = 12 * 12 * 2 * 4, kSubset = 80, kNode = 128;
  EXPECT_GE(film.scene().KeptBytesUsed(), used + kOrder + kSubset);
  EXPECT_LE(film.scene().KeptBytesUsed(), used + kOrder + kSubset + kNode);
  EXPECT_GT(film.scene().KeptBytes(), bytes);
  film.Check(20000);
  EXPECT_LE(film.scene().KeptBytesUsed(), film.scene().KeptBytes());
}

// What was another scene's may have more bytes than this one asked for: room for more leaves, but
// its order has no places for more triangles there.
TEST(GrowthTest, InTheMemoryOfALargerSceneItIsMovedAllTheSame) {
  Sheets sheets(160, 12);
  Film film = sheets.Begin(160);
  const std::vector<Mesh> all = film.meshes;
  const auto show = [&](std::size_t count) {
    film.meshes.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
    film.revisions.resize(count, 1);
    film.hidden.resize(count);
    return film.Advance();
  };
  EXPECT_FALSE(show(95));
  EXPECT_FALSE(show(94)) << "in the memory of the first one";
  film.Check(20000);
  ASSERT_TRUE(show(130));
  film.Check(20000);
}

TEST(GrowthTest, ManyMayComeOneAfterTheOther) {
  for (const std::size_t rays : {300u, 20000u}) {  // hardly anything is split, or all
    Sheets sheets(120, 10);
    Film film = sheets.Begin(60);
    film.Check(rays);
    for (std::size_t come = 1; come <= 30; ++come) {
      SCOPED_TRACE(come);
      sheets.Attach(film);
      ASSERT_TRUE(film.Advance());
      if (come % 3 != 1) film.Check(rays);
    }
    sheets.Attach(film);
    EXPECT_FALSE(film.Advance()) << "it would have grown by more than half";
    film.Check(rays);
    sheets.Attach(film, 25);
    EXPECT_TRUE(film.Advance()) << "many at once";
    film.Check(rays);
  }
}

// A subset that is split by a grid.
TEST(GrowthTest, ALargeMeshComes) {
  std::vector<Mesh> meshes = MakeSheets(2, 120);
  meshes[1].triangles.resize(meshes[1].triangles.size() / 2);
  for (const std::size_t threads : {1u, 4u}) {
    Film film({meshes[0]}, threads);
    film.Check(20000);
    film.meshes.push_back(meshes[1]);
    film.revisions.push_back(1);
    film.hidden.push_back(false);
    ASSERT_TRUE(film.Advance());
    std::vector<std::thread> comers;
    for (std::size_t t = 0; t < threads; ++t) comers.emplace_back([&] { film.Check(5000); });
    for (std::thread& comer : comers) comer.join();
    Wave(film, 1);
    ASSERT_TRUE(film.Advance());
    film.Check(5000);
  }
}

TEST(GrowthTest, WhatHasComeMovesGoesAndComesBack) {
  Sheets sheets(120, 10);
  Film film = sheets.Begin(60);
  film.Check(20000);
  for (int frame = 0; frame < 25; ++frame) {
    SCOPED_TRACE(frame);
    sheets.Attach(film);
    if (frame % 3 == 0) Wave(film, static_cast<float>(frame));  // others move meanwhile
    ASSERT_TRUE(film.Advance());
    film.Check(frame % 2 ? 100 : 20000);
    const std::size_t last = film.meshes.size() - 1;
    for (Float3& v : film.meshes[last].vertices) v[1] += 0.1f;
    ++film.revisions[last];
    ASSERT_TRUE(film.Update(last));
    film.Check(2000);
    ASSERT_TRUE(film.Hide(last));
    film.Check(2000);
    film.hidden[last] = false;
    ASSERT_TRUE(film.Update(last));
    film.Check(2000);
  }
}

TEST(GrowthTest, ACopyGrowsAndLeavesTheSceneAsItWas) {
  Sheets sheets(70, 12);
  Film film = sheets.Begin(60);
  film.Check(20000);
  for (int i = 0; i < 4; ++i) {
    Random random(9);
    std::vector<Ray> rays = unit::MakeRays(random, 5000, 1.2f), before = rays;
    film.scene().Trace(Query::kClosest, unit::ViewOf(before));
    sheets.Attach(film);
    const std::unique_ptr<Scene> previous = film.Copy();
    film.Check(5000);
    previous->Trace(Query::kClosest, unit::ViewOf(rays));
    for (std::size_t k = 0; k < rays.size(); ++k) ASSERT_TRUE(SameBits(rays[k], before[k]));
  }
}

// Neither among those that were there nor among those that come.
TEST(GrowthTest, WhatCannotBeHitIsLeftOut) {
  Sheets sheets(70, 12);
  Film film = sheets.Begin(60);
  film.meshes[7].vertices[30][1] = kNaN;
  ++film.revisions[7];
  EXPECT_FALSE(film.Advance());
  film.Check(20000);
  for (int i = 0; i < 3; ++i) {
    sheets.Attach(film);
    film.meshes.back().vertices[50][0] = kNaN;
    ASSERT_TRUE(film.Advance());
    film.Check(5000);
  }
  Wave(film, 1);
  ASSERT_TRUE(film.Advance()) << "those that are left out are the same";
  film.Check(5000);
  sheets.Attach(film);
  for (Float3& v : film.meshes.back().vertices) v[2] = kNaN;
  ASSERT_TRUE(film.Advance()) << "nothing of it can be hit";
  film.Check(5000);
  film.meshes[61].vertices[50] = film.meshes[61].vertices[51];
  ++film.revisions[61];
  EXPECT_FALSE(film.Advance()) << "there are more again";
  film.Check(5000);
}

TEST(GrowthTest, WhatComesBeforeOthersIsPartitionedAnew) {
  Sheets sheets(70, 12);
  Film film = sheets.Begin(60);
  film.Check(5000);
  sheets.Attach(film);
  film.meshes.back().geometry_id = 7;
  EXPECT_FALSE(film.Advance()) << "numbers of others change";
  film.Check(5000);
}

// Those that are split in one go, and those that are small no longer.
TEST(GrowthTest, SmallScenesArePartitionedAnew) {
  for (const std::size_t count : {6u, 14u}) {  // 1728 triangles, and 4032
    Sheets sheets(70, 12);
    Film film = sheets.Begin(count);
    film.Check(60);  // not so many that there is no room
    sheets.Attach(film);
    EXPECT_FALSE(film.Advance());
    film.Check(5000);
  }
}

/// Scenes over sheets, of which more and more are there.
class GrowingScene {
 public:
  GrowingScene(const Settings& settings, const SceneOptions& options, MemoryMonitor monitor = {})
      : device(std::make_shared<Device>(settings, std::move(monitor))), options_(options) {
    for (const Mesh& mesh : sheets_) geometries_.push_back(GeometryOf(mesh));
    for (Geometry& geometry : geometries_) geometry.revision = 1;
    scene = std::make_unique<Scene>(device, First(40), options_);
  }

  std::span<const Geometry> First(std::size_t count) const {
    return std::span(geometries_).first(count);
  }

  /// One with so many in the place of this one, which is not done yet.
  std::unique_ptr<Scene> Next(std::size_t count) const {
    return std::make_unique<Scene>(device, First(count), options_, *scene);
  }

  /// Goes on with `next`. Returns whether it took over the partition.
  bool Advance(std::unique_ptr<Scene> next) {
    const bool takes_over = next->takes_over();
    next->TakeOver(*scene);
    scene = std::move(next);
    return takes_over;
  }

  void Check(const Scene& checked, std::size_t count) const {
    Random random(3);
    std::vector<Ray> rays = unit::MakeRays(random, 10000, 1.2f), expected = rays;
    checked.Trace(Query::kClosest, unit::ViewOf(rays));
    const Scene fresh(std::make_shared<Device>(), First(count), SceneOptions{});
    fresh.Trace(Query::kClosest, unit::ViewOf(expected));
    for (std::size_t i = 0; i < rays.size(); ++i) ASSERT_TRUE(SameBits(rays[i], expected[i])) << i;
  }

  std::shared_ptr<Device> device;
  std::unique_ptr<Scene> scene;

 private:
  const std::vector<Mesh> sheets_ = MakeSheets(60, 16);
  const SceneOptions options_;
  std::vector<Geometry> geometries_;
};

// One that is used up at the beginning leaves no room for what comes; COMPACT and larger ones do.
TEST(GrowthTest, EveryBudgetHolds) {
  const auto grow = [](uint64_t budget, const SceneOptions& options, bool takes_over) {
    SCOPED_TRACE("budget " + std::to_string(budget));
    Settings settings;
    settings.budget = budget;
    GrowingScene growing(settings, options);
    growing.Check(*growing.scene, 40);
    for (std::size_t count = 41; count <= 55; ++count) {
      EXPECT_EQ(growing.Advance(growing.Next(count)), takes_over);
      growing.Check(*growing.scene, count);
      EXPECT_LE(growing.scene->KeptBytesUsed(), growing.scene->KeptBytes());
      const Scene fresh(growing.device, growing.First(count), options);
      EXPECT_EQ(growing.scene->KeptBytes(), fresh.KeptBytes());
    }
  };
  grow(0, {}, false);
  grow(kDefaultBudget, {}, true);
  grow(kUnlimitedBudget, {}, true);
  grow(2'000'000, {}, true);
  grow(kDefaultBudget, {.keep = Keep::kLittle}, true);
}

// The scene answers as before, whatever is refused, and nothing is held for what did not come.
TEST(GrowthTest, MemoryThatIsRefusedLeavesTheSceneAsItWas) {
  for (int allowed = 0; allowed < 8; ++allowed) {
    SCOPED_TRACE(allowed);
    bool refuses = false;
    int asked = 0;
    std::ptrdiff_t held = 0;
    GrowingScene growing({}, {}, [&](std::ptrdiff_t bytes) {
      if (refuses && bytes > 0 && asked++ >= allowed) return false;
      held += bytes;
      return true;
    });
    growing.Check(*growing.scene, 40);
    for (std::size_t count = 41; count <= 43; ++count) {
      const std::ptrdiff_t before = held;
      refuses = true;
      asked = 0;
      std::unique_ptr<Scene> next;
      try {
        next = growing.Next(count);
      } catch (const std::bad_alloc&) {
      }
      refuses = false;
      if (allowed == 0) {
        EXPECT_FALSE(next) << "nothing is asked for";
      }
      if (!next) {
        EXPECT_EQ(held, before);
        growing.Check(*growing.scene, count - 1);
        next = growing.Next(count);
      }
      growing.Advance(std::move(next));
      growing.Check(*growing.scene, count);
    }
  }
}

TEST(GrowthTest, APlanThatIsNotCarriedOutGivesItsMemoryBack) {
  std::ptrdiff_t held = 0;
  GrowingScene growing({}, {}, [&](std::ptrdiff_t bytes) {
    held += bytes;
    return true;
  });
  growing.Check(*growing.scene, 40);
  for (std::size_t count = 41; count <= 43; ++count) {
    const std::ptrdiff_t before = held;
    EXPECT_TRUE(growing.Next(count)->takes_over());
    EXPECT_EQ(held, before);
    growing.Check(*growing.scene, count - 1);
    const std::size_t kept = growing.scene->KeptBytes();
    ASSERT_TRUE(growing.Advance(growing.Next(count)));
    EXPECT_EQ(held - before, static_cast<std::ptrdiff_t>(growing.scene->KeptBytes() - kept));
    growing.Check(*growing.scene, count);
  }
}

// Behind triangles, which fill one lane each, one shape after the other.
TEST(GrowthTest, EveryShapeMayCome) {
  Random random(12);
  const auto device = std::make_shared<Device>();
  const Model triangles = MakeTriangles(random, 6000), more = MakeTriangles(random, 300);
  const Model points = MakePoints(random, 400);
  const std::vector<Geometry> inner = {TriangleView(more, 3)};
  const auto shown = std::make_shared<Scene>(device, inner, SceneOptions{});
  std::vector<float> corners;
  for (std::size_t i = 0; i < 800; ++i) {
    const Float3 at = random.InCube(-2, 2);
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      corners.insert(corners.end(), {at[0] + 0.1f * x, at[1] + 0.1f * y, at[2] + 0.02f * x * y});
    }
  }
  std::vector<uint32_t> quad_indices(3200);
  for (uint32_t i = 0; i < 3200; ++i) quad_indices[i] = i;
  std::vector<Geometry> all = {TriangleView(triangles, 0)};
  all.push_back(PointView(points, Shape::kSpheres, 1));
  Geometry& quads = all.emplace_back();
  quads.shape = Shape::kQuads;
  quads.vertices = {{corners.data(), 12}};
  quads.vertex_count = 3200;
  quads.primitives = {quad_indices.data(), 16};
  quads.primitive_count = 800;
  Geometry& user = all.emplace_back();
  user.shape = Shape::kUser;
  user.primitive_count = 20;
  user.bounds.function = [](void*, uint32_t primitive, uint32_t, Bounds& bounds) {
    const float at = 0.15f * static_cast<float>(primitive) - 1.5f;
    bounds = {{at, at, -at}, {at + 0.1f, at + 0.1f, 0.1f - at}};
  };
  user.intersect.function = user.occluded.function = AcceptAll;
  for (int i = 0; i < 3; ++i) {
    Geometry& instance = all.emplace_back();
    instance.shape = Shape::kInstance;
    instance.primitive_count = 1;
    instance.instanced_scene = shown;
    instance.transforms.resize(1);
    for (int axis = 0; axis < 3; ++axis) {
      instance.transforms[0].matrix.column[axis][axis] = 0.3f;
      instance.transforms[0].matrix.column[3][axis] = 0.5f * static_cast<float>(i - 1);
    }
  }
  all.push_back(TriangleView(more, 0));
  for (uint32_t id = 0; id < all.size(); ++id) all[id].geometry_id = id;
  const auto first = [&](std::size_t count) { return std::span<const Geometry>(all).first(count); };
  auto scene = std::make_unique<Scene>(device, first(1), SceneOptions{});
  const auto rays = MakeRays(random, 10000);
  Trace(*scene, rays);
  for (std::size_t count = 2; count <= all.size(); ++count) {
    auto next = std::make_unique<Scene>(device, first(count), SceneOptions{}, *scene);
    ASSERT_TRUE(next->takes_over()) << count;
    next->TakeOver(*scene);
    scene = std::move(next);
    const Scene fresh(device, first(count), SceneOptions{});
    for (const Query query : {Query::kClosest, Query::kAny}) {
      ExpectSameRays(Trace(*scene, rays, query), Trace(fresh, rays, query), std::to_string(count));
    }
    EXPECT_EQ(scene->triangle_count(), fresh.triangle_count());
  }
}

}  // namespace
}  // namespace dacrt::unit
