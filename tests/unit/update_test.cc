// A few geometries of a scene that move, go and come back without another scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "dacrt/dacrt.h"
#include "film.h"
#include "shape_scenes.h"
#include "unit_test.h"

namespace dacrt::unit {
namespace {

TEST(UpdateTest, OneMeshOfManyIsUpdatedInItsPlace) {
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
TEST(UpdateTest, AnUpdateThatWouldNotDoChangesNothing) {
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
TEST(UpdateTest, HiddenMeshesAreNotThereAndComeBack) {
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
TEST(UpdateTest, HiddenMeshesOfSmallScenes) {
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

TEST(UpdateTest, AllMeshesMayBeHidden) {
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

// Still and moving ones, beside triangles.
TEST(UpdateTest, PointsGoAndComeBack) {
  Random random(6);
  const Model triangles = MakeTriangles(random, 2000);
  constexpr Shape kPoints[] = {Shape::kSpheres, Shape::kDiscs, Shape::kOrientedDiscs};
  std::vector<Model> points;
  for (uint32_t id = 1; id <= 6; ++id) {
    points.push_back(MakePoints(random, 400));
    if (id <= 3) continue;
    points.back().steps.push_back(points.back().steps[0]);
    for (float& value : points.back().steps[1]) value *= 1.1f;
  }
  const auto describe = [&](const std::vector<Model>& models, uint32_t id) {
    if (id == 0) return TriangleView(triangles, 0);
    Geometry geometry = PointView(models[id - 1], kPoints[id % 3], id);
    geometry.normals.resize(geometry.normals.size() * geometry.vertices.size(),
                            {models[id - 1].normals.data(), 12});
    return geometry;
  };
  const auto make = [&](const std::vector<Model>& models, const std::vector<bool>& shows) {
    std::vector<Geometry> geometries;
    for (uint32_t id = 0; id < shows.size(); ++id) {
      if (shows[id]) geometries.push_back(describe(models, id));
    }
    return MakeScene(geometries, kDefaultBudget);
  };
  const auto rays = MakeRays(random, 10000);
  std::vector<Model> held = points;
  std::vector<bool> shows(7, true);
  const auto scene = make(held, shows);
  const auto all = Trace(*scene, rays);
  const auto expect_right = [&](const std::string& what) {
    const auto fresh = make(points, shows);
    for (const Query query : {Query::kClosest, Query::kAny}) {
      ExpectSameRays(Trace(*scene, rays, query), Trace(*fresh, rays, query), what);
    }
  };
  for (const uint32_t id : {2u, 6u, 1u, 4u, 3u, 5u}) {
    Geometry hidden;
    hidden.geometry_id = id;
    hidden.hidden = true;
    ASSERT_TRUE(scene->Update({hidden})) << id;
    shows[id] = false;
    // It is not read any more: these would be hit by rays that hit nothing else.
    for (auto& step : held[id - 1].steps) std::fill(step.begin(), step.end(), 100.0f);
    expect_right("without " + std::to_string(id));
  }
  for (const uint32_t id : {5u, 1u, 6u, 2u, 3u, 4u}) {
    ASSERT_TRUE(scene->Update({describe(points, id)})) << id;
    shows[id] = true;
    expect_right("again with " + std::to_string(id));
  }
  ExpectSameRays(Trace(*scene, rays), all, "all");
}

/// Still and moving ones, beside triangles; rays come alone, and many together.
void ExpectThatInstancesGoAndComeBack(uint64_t budget) {
  Random random(8);
  Settings settings;
  settings.budget = budget;
  const auto device = std::make_shared<Device>(settings);
  const Model outside = MakeTriangles(random, 500), inside = MakeTriangles(random, 300);
  const std::vector<Geometry> inner = {TriangleView(inside, 3)};
  const auto shown = std::make_shared<Scene>(device, inner, SceneOptions{});
  std::vector<Geometry> all = {TriangleView(outside, 0)};
  for (uint32_t id = 1; id <= 24; ++id) {
    Geometry& instance = all.emplace_back();
    instance.shape = Shape::kInstance;
    instance.geometry_id = id;
    instance.primitive_count = 1;
    instance.revision = 1;
    instance.instanced_scene = shown;
    instance.transforms.resize(1 + id % 2);
    for (TransformStep& step : instance.transforms) {
      const Float3 at = random.InCube(-2, 2);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        step.matrix.column[axis][axis] = 0.3f;
        step.matrix.column[3][axis] = at[axis];
      }
    }
  }
  std::vector<bool> shows(all.size(), true);
  const auto make = [&] {
    std::vector<Geometry> geometries;
    for (std::size_t id = 0; id < all.size(); ++id) {
      if (shows[id]) geometries.push_back(all[id]);
    }
    return Scene(device, geometries, SceneOptions{});
  };
  Scene scene = make();
  const auto expect_right = [&](uint32_t id) {
    const Scene fresh = make();
    for (const std::size_t count : {1u, 50u, 9000u}) {
      auto rays = MakeRays(random, count);
      // Those that leave the scene towards the corner of all space, too.
      for (std::size_t i = 0; i < count / 3; ++i) {
        const float at = random.InCube(-3, 3)[0];
        for (std::size_t axis = 0; axis < 3; ++axis) rays[i].org[axis] = at, rays[i].dir[axis] = 1;
      }
      for (const Query query : {Query::kClosest, Query::kAny}) {
        ExpectSameRays(Trace(scene, rays, query), Trace(fresh, rays, query), std::to_string(id));
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(scene.bounds().lower[axis], fresh.bounds().lower[axis]);
      EXPECT_NEAR(scene.bounds().lower[axis], fresh.bounds().lower[axis], 1e-3) << id;
      EXPECT_NEAR(scene.bounds().upper[axis], fresh.bounds().upper[axis], 1e-3) << id;
    }
  };
  expect_right(0);
  for (const uint32_t step : {1u, 3u, 2u}) {  // all, then some
    for (uint32_t id = step; id < all.size(); id += step) {
      Geometry hidden;
      hidden.geometry_id = id;
      hidden.hidden = true;
      ASSERT_TRUE(scene.Update({hidden})) << id;
      ASSERT_TRUE(scene.Update({hidden})) << id << " is hidden";
      shows[id] = false;
      if (id % 5 == 0) expect_right(id);
    }
    if (step == 1) {
      shows[0] = false;
      Geometry hidden;
      hidden.hidden = true;
      ASSERT_TRUE(scene.Update({hidden}));
      const auto rays = MakeRays(random, 3000);
      EXPECT_EQ(CountHits(Trace(scene, rays)), 0u);
      EXPECT_GT(scene.bounds().lower[0], scene.bounds().upper[0]);
      shows[0] = true;
      ASSERT_TRUE(scene.Update({all[0]}));
    }
    for (uint32_t id = step; id < all.size(); id += step) {
      if (id % 7 == 0) all[id].transforms[0].matrix.column[3][1] += 0.5f, ++all[id].revision;
      ASSERT_TRUE(scene.Update({all[id]})) << id;
      shows[id] = true;
      if (id % 5 == 0) expect_right(id);
    }
    expect_right(0);
  }
}

TEST(UpdateTest, InstancesGoAndComeBack) { ExpectThatInstancesGoAndComeBack(kDefaultBudget); }

TEST(UpdateTest, InstancesGoAndComeBackWhereThereIsNoRoomForNodes) {
  ExpectThatInstancesGoAndComeBack(5);
}

/// Instances of one scene beside triangles, every third of two time steps.
struct ManyInstances {
  explicit ManyInstances(uint64_t budget = kDefaultBudget) {
    Settings settings;
    settings.budget = budget;
    device = std::make_shared<Device>(settings);
    shown = Show(0.9f);
    all = {TriangleView(outside, 4)};
    for (uint32_t id = 5; id < 105; ++id) {
      Geometry& instance = all.emplace_back(InstanceOf(shown, {}, id == 104 ? 200 : id));
      instance.transforms.resize(id % 3 == 0 ? 2 : 1);
      Move(instance);
    }
    scene = std::make_unique<Scene>(device, all, SceneOptions{});
    Trace(*scene, MakeRays(random, 9000));  // for what is not split nothing is kept
  }

  /// A scene of some triangles, `size` times as large as they are.
  std::shared_ptr<const Scene> Show(float size) {
    Model& model = *insides.emplace_back(std::make_unique<Model>(inside));
    for (auto& step : model.steps) {
      for (float& value : step) value *= size;
    }
    const std::vector<Geometry> geometries = {TriangleView(model, 3)};
    return std::make_shared<Scene>(device, geometries, SceneOptions{});
  }

  void Move(Geometry& instance) {
    for (TransformStep& step : instance.transforms) {
      const Float3 at = random.InCube(-2, 2);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        step.matrix.column[axis][axis] = 0.3f;
        step.matrix.column[3][axis] = at[axis];
      }
    }
  }

  static Placement PlacementOf(const Geometry& instance) {
    return {instance.geometry_id, instance.transforms};
  }

  /// Against a scene that is made of what there is now.
  void ExpectRight(const std::string& what) {
    const Scene fresh(device, all, SceneOptions{});
    for (const std::size_t count : {1u, 50u, 9000u}) {
      const auto rays = MakeRays(random, count);
      for (const Query query : {Query::kClosest, Query::kAny}) {
        ExpectSameRays(Trace(*scene, rays, query), Trace(fresh, rays, query), what);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(scene->bounds().lower[axis], fresh.bounds().lower[axis]) << what;
      EXPECT_EQ(scene->bounds().upper[axis], fresh.bounds().upper[axis]) << what;
    }
    // These are asked of the geometries, and not of the partition.
    const LinearBounds own = scene->linear_bounds(), expected = fresh.linear_bounds();
    EXPECT_EQ(std::memcmp(&own, &expected, sizeof(own)), 0) << what;
  }

  Random random{8};
  const Model outside = MakeTriangles(random, 500), inside = MakeTriangles(random, 300);
  std::vector<std::unique_ptr<Model>> insides;
  std::shared_ptr<Device> device;
  std::shared_ptr<const Scene> shown;
  std::vector<Geometry> all;
  std::unique_ptr<Scene> scene;
};

void ExpectThatInstancesArePlaced(uint64_t budget) {
  ManyInstances many(budget);
  for (const std::size_t stride : {1u, 7u, 50u, 2u}) {
    std::vector<Placement> placed;
    for (std::size_t i = 1; i < many.all.size(); i += stride) {
      many.Move(many.all[i]);
      placed.push_back(ManyInstances::PlacementOf(many.all[i]));
    }
    std::vector<Geometry> changed;
    if (stride == 7) {
      many.all[3].mask = 0;
      changed.push_back(many.all[3]);
    }
    ASSERT_TRUE(many.scene->Update(changed, placed)) << stride;
    many.ExpectRight("every " + std::to_string(stride));
  }
  ASSERT_TRUE(many.scene->Update({}, {}));
  many.ExpectRight("none");
}

TEST(UpdateTest, InstancesArePlaced) { ExpectThatInstancesArePlaced(kDefaultBudget); }

TEST(UpdateTest, InstancesArePlacedWhereThereIsNoRoomForNodes) { ExpectThatInstancesArePlaced(5); }

// Each asks for another scene; this one is then still what it was.
TEST(UpdateTest, APlacementThatWouldNotDoChangesNothing) {
  ManyInstances many;
  Geometry first = many.all[1], second = many.all[2];  // which go before
  many.Move(second);
  first.transforms[0].matrix.column[3][0] = 50;  // beyond all bounds
  const auto refuses = [&](const char* what, const Placement& placement) {
    EXPECT_FALSE(many.scene->Update(
        {second}, std::vector<Placement>{ManyInstances::PlacementOf(first), placement}))
        << what;
    many.ExpectRight(what);
  };
  Geometry other = many.all[7];
  other.geometry_id = 104;
  refuses("an ID that there is not", ManyInstances::PlacementOf(other));
  other.geometry_id = 4;
  refuses("not an instance", ManyInstances::PlacementOf(other));
  for (const std::size_t i : {5u, 7u}) {
    other = many.all[i];
    other.transforms.resize(3 - other.transforms.size());
    refuses("another number of time steps", ManyInstances::PlacementOf(other));
  }
  refuses("one twice", ManyInstances::PlacementOf(first));
  refuses("one that changes, too", ManyInstances::PlacementOf(second));
  other = many.all[7];
  other.transforms[0].matrix.column[3][0] = std::numeric_limits<float>::infinity();
  refuses("one that cannot be hit any more", ManyInstances::PlacementOf(other));
  Geometry hidden;
  hidden.geometry_id = many.all[7].geometry_id;
  hidden.hidden = true;
  ASSERT_TRUE(many.scene->Update({hidden}));
  EXPECT_FALSE(
      many.scene->Update({}, std::vector<Placement>{ManyInstances::PlacementOf(many.all[7])}));
  many.all.erase(many.all.begin() + 7);
  const auto rays = MakeRays(many.random, 3000);
  ExpectSameRays(Trace(*many.scene, rays), Trace(Scene(many.device, many.all), rays), "hidden");
}

Geometry HiddenOf(const Geometry& geometry) {
  Geometry hidden;
  hidden.geometry_id = geometry.geometry_id;
  hidden.hidden = true;
  return hidden;
}

// The program may release what they have shown. Rays come to where they are, too.
TEST(UpdateTest, HiddenInstancesKeepNothing) {
  for (const uint64_t budget : {kDefaultBudget, uint64_t{5}}) {
    ManyInstances many(budget);
    const std::weak_ptr<const Scene> shown = many.shown;
    while (many.all.size() > 1) {
      ASSERT_TRUE(many.scene->Update({HiddenOf(many.all.back())}));
      many.all.pop_back();
    }
    many.shown = nullptr;
    EXPECT_TRUE(shown.expired());
    many.ExpectRight("without instances");
    const Scene fresh(many.device, many.all, SceneOptions{});
    for (const std::size_t count : {1u, 50u, 9000u}) {
      auto rays = MakeRays(many.random, count);
      for (auto& ray : rays) {
        const float at = many.random.InCube(-3, 3)[0];
        ray.org = {at, at, at};
        ray.dir = {1, 1, 1};
      }
      for (const Query query : {Query::kClosest, Query::kAny}) {
        ExpectSameRays(Trace(*many.scene, rays, query), Trace(fresh, rays, query), "corner");
      }
    }
  }
}

TEST(UpdateTest, InstancesMayShowOtherScenes) {
  ManyInstances many;
  std::weak_ptr<const Scene> before = many.shown;
  many.shown = nullptr;
  for (const float size : {0.5f, 1.1f, 0.8f}) {
    const auto shown = many.Show(size);
    for (std::size_t i = 1; i < many.all.size(); ++i) {
      if (i % 2 == 1) {
        ASSERT_TRUE(many.scene->Update({HiddenOf(many.all[i])}));
      }
      many.all[i].instanced_scene = shown;
      ASSERT_TRUE(many.scene->Update({many.all[i]}));
    }
    EXPECT_TRUE(before.expired()) << size;
    many.ExpectRight(std::to_string(size));
    before = shown;
  }
}

// Rays need not be asked for their masks before.
TEST(UpdateTest, AnotherSceneMayHaveMasks) {
  ManyInstances many;
  std::vector<Geometry> masked = {TriangleView(many.inside, 3)};
  masked[0].mask = 2;
  const auto shown = std::make_shared<Scene>(many.device, masked, SceneOptions{});
  for (const std::size_t i : {1u, 8u}) {
    ASSERT_TRUE(many.scene->Update({HiddenOf(many.all[i])}));
    many.all[i].instanced_scene = shown;
    ASSERT_TRUE(many.scene->Update({many.all[i]}));
  }
  auto rays = MakeRays(many.random, 9000);
  for (auto& ray : rays) ray.mask = 1;
  ExpectSameRays(Trace(*many.scene, rays), Trace(Scene(many.device, many.all), rays), "masks");
}

// Calls need memory for them that was not reserved when the scene was made.
TEST(UpdateTest, AnotherSceneMayNotBringTheFirstCallbacks) {
  ManyInstances many;
  std::vector<Geometry> filtered = {TriangleView(many.inside, 3)};
  filtered[0].closest_filter.function = &AcceptAll;
  Geometry instance = many.all[1];
  instance.instanced_scene = std::make_shared<Scene>(many.device, filtered, SceneOptions{});
  EXPECT_FALSE(many.scene->Update({instance}));
  many.ExpectRight("the same");
}

// Leaves know the scenes of their instances: they went on with the old one where only that differs.
TEST(UpdateTest, AnInstanceOfTheSameRevisionMayShowAnotherScene) {
  ManyInstances many;
  for (Geometry& geometry : many.all) geometry.revision = 1;
  const Scene before(many.device, many.all, SceneOptions{});
  const auto rays = MakeRays(many.random, 9000);
  Trace(before, rays);
  const auto shown = many.Show(0.8f);
  for (std::size_t i = 1; i < many.all.size(); i += 2) many.all[i].instanced_scene = shown;
  Scene after(many.device, many.all, SceneOptions{}, before);
  ASSERT_TRUE(after.takes_over());
  after.TakeCopy(before);
  ExpectSameRays(Trace(after, rays), Trace(Scene(many.device, many.all), rays), "another scene");
}

}  // namespace
}  // namespace dacrt::unit
