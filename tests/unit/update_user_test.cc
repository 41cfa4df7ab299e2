// User geometries of a scene that move, go and come back without another scene.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "dacrt/dacrt.h"
#include "shape_scenes.h"
#include "unit_test.h"
#include "user_spheres.h"

namespace dacrt::unit {
namespace {

constexpr uint32_t kUsers = 6;

/// Some beside triangles, every third of two time steps, between which nothing moves but bounds.
struct Spheres {
  explicit Spheres(uint64_t budget) {
    Settings settings;
    settings.budget = budget;
    device = std::make_shared<Device>(settings);
    centers.resize(kUsers);
    for (uint32_t id = 1; id <= kUsers; ++id) {
      for (std::size_t i = 0; i < 40 * id; ++i) centers[id - 1].push_back(random.InCube(-2, 2));
    }
    held = centers;
    shows.assign(kUsers + 1, true);
    scene = std::make_unique<Scene>(device, All(held), SceneOptions{});
  }

  Geometry Describe(const std::vector<Float3>& places, uint32_t id) const {
    Geometry user = UserSpheres::Of(places, id);
    user.revision = revision;
    if (id % 3 == 0) {
      user.user_time_steps = 2;
      user.bounds.function = [](void* data, uint32_t primitive, uint32_t step, Bounds& bounds) {
        UserSpheres::Bound(data, primitive, step, bounds);
        if (step == 1) bounds.lower[1] -= 0.5f;
      };
    }
    user.point_callback.function = [](void*, const PointCandidate& candidate) {
      ++static_cast<std::vector<int>*>(candidate.call)->at(candidate.geometry_id);
      return candidate.radius;
    };
    return user;
  }

  std::vector<Geometry> All(const std::vector<std::vector<Float3>>& places) const {
    std::vector<Geometry> geometries = {TriangleView(triangles, 0)};
    for (uint32_t id = 1; id <= kUsers; ++id) {
      if (shows[id]) geometries.push_back(Describe(places[id - 1], id));
    }
    return geometries;
  }

  bool Hide(uint32_t id) {
    Geometry hidden;
    hidden.geometry_id = id;
    hidden.hidden = true;
    shows[id] = false;
    return scene->Update({hidden});
  }

  bool Show(uint32_t id) {
    shows[id] = true;
    held[id - 1] = centers[id - 1];
    return scene->Update({Describe(held[id - 1], id)});
  }

  void Move(uint32_t id) {
    ++revision;
    for (Float3& center : centers[id - 1]) center[2] += 0.3f;
  }

  void ExpectRight(const std::string& what) {
    const Scene fresh(device, All(centers), SceneOptions{});
    for (const std::size_t count : {1u, 50u, 9000u}) {
      auto rays = MakeRays(random, count);
      // Those that leave the scene towards the corner of all space, too.
      for (std::size_t i = 0; i < count / 3; ++i) {
        const float at = random.InCube(-3, 3)[0];
        rays[i].org = {at, at, at};
        rays[i].dir = {1, 1, 1};
      }
      for (const Query query : {Query::kClosest, Query::kAny}) {
        ExpectSameRays(Trace(*scene, rays, query), Trace(fresh, rays, query), what);
      }
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(scene->bounds().lower[axis], fresh.bounds().lower[axis]) << what;
      EXPECT_EQ(scene->bounds().upper[axis], fresh.bounds().upper[axis]) << what;
    }
    const LinearBounds own = scene->linear_bounds(), expected = fresh.linear_bounds();
    EXPECT_EQ(std::memcmp(&own, &expected, sizeof(own)), 0) << what;
    EXPECT_EQ(CountNear(*scene), CountNear(fresh)) << what;
  }

  static std::vector<int> CountNear(const Scene& scene) {
    std::vector<int> counts(kUsers + 1);
    scene.QueryPoint({.point = {0, 0, 0}, .radius = 1.5f, .time = 0.5f, .call = &counts});
    return counts;
  }

  Random random{17};
  const Model triangles = MakeTriangles(random, 3000);
  std::shared_ptr<Device> device;
  std::vector<std::vector<Float3>> centers, held;  ///< as they are, and as the scene has them
  std::vector<bool> shows;
  uint64_t revision = 1;
  std::unique_ptr<Scene> scene;
};

void ExpectThatTheyGoAndComeBack(uint64_t budget) {
  Spheres spheres(budget);
  spheres.ExpectRight("all");
  for (const uint32_t id : {2u, 6u, 1u, 3u}) {
    ASSERT_TRUE(spheres.Hide(id)) << id;
    ASSERT_TRUE(spheres.Hide(id)) << id << " is hidden";
    spheres.ExpectRight("without " + std::to_string(id));
  }
  for (const uint32_t id : {3u, 1u, 6u, 2u}) {
    if (id % 2 == 0) spheres.Move(id);
    ASSERT_TRUE(spheres.Show(id)) << id;
    spheres.ExpectRight("again with " + std::to_string(id));
  }
  for (uint32_t id = 1; id <= kUsers; ++id) {
    spheres.Move(id);
    ASSERT_TRUE(spheres.Show(id)) << id;
    spheres.ExpectRight("moved " + std::to_string(id));
    ASSERT_TRUE(spheres.Show(id)) << id << " is where it was";
    spheres.ExpectRight("still " + std::to_string(id));
  }
}

TEST(UpdateUserTest, TheyGoAndComeBack) { ExpectThatTheyGoAndComeBack(kDefaultBudget); }

TEST(UpdateUserTest, TheyGoAndComeBackWhereThereIsNoRoomForNodes) {
  ExpectThatTheyGoAndComeBack(5);
}

TEST(UpdateUserTest, OthersThatWouldNotDoChangeNothing) {
  Spheres spheres(kDefaultBudget);
  spheres.ExpectRight("all");
  const auto refuses = [&](const char* what, const Geometry& geometry) {
    EXPECT_FALSE(spheres.scene->Update({geometry})) << what;
    spheres.ExpectRight(what);
  };
  Geometry other = spheres.Describe(spheres.held[1], 2);
  --other.primitive_count;
  refuses("another number of primitives", other);
  other = spheres.Describe(spheres.held[1], 2);
  other.user_time_steps = 2;
  refuses("another number of time steps", other);
  ++spheres.revision;
  std::vector<Float3> spoilt = spheres.held[1];
  spoilt[3][1] = std::numeric_limits<float>::quiet_NaN();
  refuses("other primitives can be hit", spheres.Describe(spoilt, 2));
}

}  // namespace
}  // namespace dacrt::unit
