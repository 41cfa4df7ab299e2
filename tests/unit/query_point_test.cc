// Scene::QueryPoint through the public API: complete, each primitive once, and near ones first, on
// every instruction set and with every kind of partition.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "dacrt/dacrt.h"
#include "query/point_domain.h"
#include "unit_test.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::kInfinity;
using unit::kNaN;
using unit::Mesh;
using unit::Random;

constexpr uint64_t kBudgets[] = {0, 5 * 20000, kDefaultBudget, kUnlimitedBudget};

/// The box of a triangle.
Bounds BoxOf(const Mesh& mesh, uint32_t triangle) {
  Bounds box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (int corner = 0; corner < 3; ++corner) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lower[axis] = std::min(box.lower[axis], mesh.Corner(triangle, corner)[axis]);
      box.upper[axis] = std::max(box.upper[axis], mesh.Corner(triangle, corner)[axis]);
    }
  }
  return box;
}

double DistanceToBox(const Float3& point, const Bounds& box) {
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double beyond = std::max(
        {double{box.lower[axis]} - point[axis], double{point[axis]} - box.upper[axis], 0.0});
    square += beyond * beyond;
  }
  return std::sqrt(square);
}

/// What callbacks are called with, and the answers.
struct Visits {
  const Mesh* mesh = nullptr;
  Float3 point{};  ///< where boxes are measured from, if the radius is to shrink to the nearest one
  bool shrinks = false;
  bool stops = false;
  bool grows = false;
  std::vector<int> counts;
  std::size_t total = 0;

  static float Visit(void*, const PointCandidate& candidate) {
    auto& visits = *static_cast<Visits*>(candidate.call);
    ++visits.counts[candidate.primitive_id];
    ++visits.total;
    if (visits.stops) return -1;
    if (visits.grows) return 4 * candidate.radius;
    if (!visits.shrinks) return candidate.radius;
    const double distance =
        DistanceToBox(visits.point, BoxOf(*visits.mesh, candidate.primitive_id));
    return std::min(candidate.radius, static_cast<float>(distance));
  }
};

/// Triangles in clusters, which a grid tells apart, and some that can not be hit.
Mesh MakeMesh(std::size_t count) {
  Random random(8);
  Mesh mesh;
  Float3 center{};
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 500 == 0) center = random.InCube(-10, 10);
    Float3 corners[3];
    for (Float3& corner : corners) {
      corner = random.InCube(-1, 1);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        corner[axis] = center[axis] + 0.1f * corner[axis] + static_cast<float>(i % 7);
      }
    }
    if (i % 1000 == 3) corners[1][1] = kNaN;
    mesh.Add(corners[0], corners[1], corners[2]);
  }
  return mesh;
}

bool CanBeHit(uint32_t triangle) { return triangle % 1000 != 3; }

/// A scene of one mesh.
class QueryPoint : public testing::Test {
 protected:
  static Geometry View(const Mesh& mesh) {
    Geometry view;
    view.vertices = {{mesh.vertices.data(), sizeof(Float3)}};
    view.vertex_count = mesh.vertices.size();
    view.primitives = {mesh.triangles.data(), 12};
    view.primitive_count = mesh.triangles.size();
    view.point_callback = {Visits::Visit, nullptr};
    return view;
  }

  std::unique_ptr<Scene> MakeScene(const Geometry& geometry, const Settings& settings) const {
    return std::make_unique<Scene>(std::make_shared<Device>(settings), std::span(&geometry, 1),
                                   SceneOptions{});
  }

  Visits NewVisits() const {
    Visits visits;
    visits.mesh = &mesh_;
    visits.counts.resize(mesh_.triangles.size());
    return visits;
  }

  Visits Run(const Scene& scene, PointQuery query, Visits visits) const {
    query.call = &visits;
    scene.QueryPoint(query);
    return visits;
  }

  /// Calls `body(scene)` for each instruction set and each kind of partition.
  template <class Body>
  void ForEachScene(const Body& body) const {
    for (const InstructionSet instruction_set : AvailableInstructionSets()) {
      for (const uint64_t budget : kBudgets) {
        SCOPED_TRACE(std::string(Name(instruction_set)) + ", budget " + std::to_string(budget));
        Settings settings;
        settings.instruction_set = instruction_set;
        settings.budget = budget;
        body(*MakeScene(View(mesh_), settings));
        if (HasFailure()) return;
      }
    }
  }

  Mesh mesh_ = MakeMesh(20000);
};

PointQuery QueryAt(const Float3& point, float radius) {
  return {{point[0], point[1], point[2]}, radius};
}

TEST_F(QueryPoint, VisitsWhatLiesWithinTheRadiusOnce) {
  ForEachScene([&](const Scene& scene) {
    Random random(1);
    for (const float radius : {0.0f, 0.3f, 3.0f, kInfinity}) {
      const Float3 point = random.InCube(-8, 12);
      const Visits visits = Run(scene, QueryAt(point, radius), NewVisits());
      for (uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
        if (!CanBeHit(i)) {
          ASSERT_EQ(visits.counts[i], 0);
          continue;
        }
        const double distance = DistanceToBox(point, BoxOf(mesh_, i));
        if (distance <= radius) {
          ASSERT_EQ(visits.counts[i], 1) << i;
        }
        if (distance > radius * 1.0001 + 1e-6) {
          ASSERT_EQ(visits.counts[i], 0) << i;
        }
      }
    }
  });
}

TEST_F(QueryPoint, FindsTheNearestWithFewVisits) {
  ForEachScene([&](const Scene& scene) {
    Random random(2);
    for (int i = 0; i < 20; ++i) {
      Visits visits = NewVisits();
      visits.shrinks = true;
      visits.point = random.InCube(-15, 15);
      double nearest = kInfinity;
      for (uint32_t k = 0; k < mesh_.triangles.size(); ++k) {
        if (CanBeHit(k)) nearest = std::min(nearest, DistanceToBox(visits.point, BoxOf(mesh_, k)));
      }
      const Visits after = Run(scene, QueryAt(visits.point, kInfinity), visits);
      double found = kInfinity;
      for (uint32_t k = 0; k < mesh_.triangles.size(); ++k) {
        if (after.counts[k] > 0) {
          found = std::min(found, DistanceToBox(visits.point, BoxOf(mesh_, k)));
        }
      }
      ASSERT_EQ(found, nearest);
      // A few leaves where there is room for all nodes. Measured: at most 11.
      if (scene.KeptBytes() > 8 * mesh_.triangles.size()) {
        ASSERT_LT(after.total, 30u);
      }
    }
  });
}

TEST_F(QueryPoint, StopsWhereACallbackSaysSo) {
  ForEachScene([&](const Scene& scene) {
    Visits visits = NewVisits();
    visits.stops = true;
    ASSERT_EQ(Run(scene, QueryAt({0, 0, 0}, kInfinity), visits).total, 1u);
  });
}

TEST_F(QueryPoint, NoCallbackMakesTheRadiusLarger) {
  ForEachScene([&](const Scene& scene) {
    Visits grows = NewVisits();
    grows.grows = true;
    const PointQuery query = QueryAt({0, 0, 0}, 6);
    const Visits visits = Run(scene, query, NewVisits());
    ASSERT_GT(visits.total, 0u);
    ASSERT_EQ(Run(scene, query, grows).counts, visits.counts);
  });
}

// While it is on its way rays buy better nodes for where it is, and others take the memory of those
// that it is in.
TEST_F(QueryPoint, StaysInItsNodesWhileRaysBuyOthers) {
  struct Tracer {
    const Scene* scene;
    std::vector<int> counts;
    bool has_traced;

    static float Visit(void*, const PointCandidate& candidate) {
      auto& tracer = *static_cast<Tracer*>(candidate.call);
      ++tracer.counts[candidate.primitive_id];
      if (tracer.has_traced) return candidate.radius;
      tracer.has_traced = true;
      Random random(9);
      std::vector<unit::Ray> rays(20000);
      for (unit::Ray& ray : rays) {
        const Float3 from = random.InCube(-15, 15), to = random.InCube(-8, 12);
        ray = unit::MakeRay(from, {to[0] - from[0], to[1] - from[1], to[2] - from[2]});
      }
      tracer.scene->Trace(Query::kClosest, unit::ViewOf(rays), {});
      return candidate.radius;
    }
  };
  Geometry view = View(mesh_);
  view.point_callback = {Tracer::Visit, nullptr};
  for (const InstructionSet instruction_set : AvailableInstructionSets()) {
    SCOPED_TRACE(Name(instruction_set));
    Settings settings;
    settings.instruction_set = instruction_set;
    const auto scene = MakeScene(view, settings);
    Tracer tracer{scene.get(), std::vector<int>(mesh_.triangles.size()), false};
    PointQuery query = QueryAt({0, 0, 0}, kInfinity);
    // Nodes are rented by the first, and bought by what it calls.
    query.call = &tracer;
    scene->QueryPoint(query);
    for (uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      ASSERT_EQ(tracer.counts[i], CanBeHit(i)) << i;
    }
  }
}

TEST_F(QueryPoint, GoesThroughATransform) {
  // Of the space that the mesh is in, from the world's: a similarity, and not.
  const AffineTransform transforms[] = {
      {{{0, 0.25f, 0}, {-0.25f, 0, 0}, {0, 0, 0.25f}, {1, 2, 3}}},
      {{{0.25f, 0, 0}, {0.1f, 2, 0}, {0, 0.5f, 0.5f}, {1, 2, 3}}}};
  EXPECT_EQ(SimilarityScale(transforms[0]), 0.25f);
  EXPECT_EQ(SimilarityScale(transforms[1]), 0);
  ForEachScene([&](const Scene& scene) {
    Random random(3);
    for (const AffineTransform& to_scene : transforms) {
      const AffineTransform back = Inverse(to_scene);
      for (const float radius : {1.0f, 4.0f, 16.0f}) {
        PointQuery query = QueryAt(random.InCube(-20, 20), radius);
        query.to_scene = &to_scene;
        const Visits visits = Run(scene, query, NewVisits());
        for (uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
          if (!CanBeHit(i)) continue;
          double nearest = kInfinity;  // corner, in the world
          for (int corner = 0; corner < 3; ++corner) {
            double square = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
              double value = double{back.column[3][axis]} - query.point[axis];
              for (std::size_t k = 0; k < 3; ++k) {
                value += double{back.column[k][axis]} * mesh_.Corner(i, corner)[k];
              }
              square += value * value;
            }
            nearest = std::min(nearest, std::sqrt(square));
          }
          if (nearest <= radius) {
            ASSERT_EQ(visits.counts[i], 1) << i;
          }
          ASSERT_LE(visits.counts[i], 1);
        }
      }
    }
  });
}

TEST_F(QueryPoint, FindsNothingWithoutAPlaceOrARadius) {
  ForEachScene([&](const Scene& scene) {
    for (const PointQuery& query : {QueryAt({kNaN, 0, 0}, 1), QueryAt({0, kNaN, 0}, kInfinity),
                                    QueryAt({0, 0, 0}, kNaN), QueryAt({0, 0, 0}, -1)}) {
      ASSERT_EQ(Run(scene, query, NewVisits()).total, 0u);
    }
    ASSERT_GT(Run(scene, QueryAt({kInfinity, 0, 0}, kInfinity), NewVisits()).total, 0u);
    // A flat instance has no way back.
    const AffineTransform flat = Inverse({{{1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 0, 0}}});
    PointQuery query = QueryAt({0, 0, 0}, 1);
    query.to_scene = &flat;
    ASSERT_EQ(Run(scene, query, NewVisits()).total, 0u);
  });
}

TEST_F(QueryPoint, PassesGeometriesByWithoutACallback) {
  Geometry geometry = View(mesh_);
  geometry.point_callback = {};
  MakeScene(geometry, {})->QueryPoint(QueryAt({0, 0, 0}, kInfinity));
}

// An empty subset must not be split: there is no leaf to end it.
TEST(QueryPointOfNothing, AnEmptySceneHasNothingToVisit) {
  for (const uint64_t budget : {uint64_t{0}, uint64_t{1}, kDefaultBudget}) {
    Settings settings;
    settings.budget = budget;
    const Scene scene(std::make_shared<Device>(settings), {});
    int count = 0;
    PointQuery query = QueryAt({0, 0, 0}, kInfinity);
    query.call = &count;
    scene.QueryPoint(query);
    EXPECT_EQ(count, 0);
  }
}

// What comes after an instance is looked at with the radius that was left there.
TEST_F(QueryPoint, ARadiusThatShrankInAnInstanceStaysSo) {
  Settings settings;
  settings.budget = 0;
  const auto device = std::make_shared<Device>(settings);
  const Mesh mesh = MakeMesh(1);
  const auto stop_at_one = [](void*, const PointCandidate& candidate) {
    ++*static_cast<int*>(candidate.call);
    return std::min(candidate.radius, 1.0f);
  };
  Geometry triangle = View(mesh);
  triangle.point_callback.function = stop_at_one;
  const auto inner =
      std::make_shared<const Scene>(device, std::span(&triangle, 1), SceneOptions{});
  // In another instance, and in the scene itself.
  Mesh beside = mesh;
  for (Float3& vertex : beside.vertices) vertex[0] += 5;
  std::vector<Geometry> geometries(3);
  geometries[2] = View(beside);
  geometries[2].geometry_id = 2;
  geometries[2].point_callback.function = stop_at_one;
  for (uint32_t i = 0; i < 2; ++i) {
    geometries[i].shape = Shape::kInstance;
    geometries[i].geometry_id = i;
    geometries[i].primitive_count = 1;
    geometries[i].instanced_scene = inner;
    TransformStep step;
    step.matrix.column[3][0] = 5.0f * static_cast<float>(i);
    geometries[i].transforms = {step};
  }
  const Scene scene(device, geometries, SceneOptions{});
  int count = 0;
  PointQuery query = QueryAt(mesh.Corner(0, 0), kInfinity);
  query.call = &count;
  scene.QueryPoint(query);
  EXPECT_EQ(count, 1);
}

// Far from the origin, where the point lands beside where it should, and with scales that are those
// of a similarity only nearly: the domain holds the ball all the same.
TEST(PointDomainTest, HoldsWhatTheTransformShouldLeadTo) {
  Random random(5);
  for (int round = 0; round < 1000; ++round) {
    AffineTransform transform{};
    const float far = std::exp2(random.Uniform(-5, 20));
    const Float3 point = random.InCube(-far, far);
    double exact[3];
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < 3; ++i) transform.column[i][axis] = random.Uniform(-1, 1);
      // Such that the point comes to lie near the origin.
      double value = 0;
      for (std::size_t i = 0; i < 3; ++i) value += double{transform.column[i][axis]} * point[i];
      transform.column[3][axis] = static_cast<float>(-value);
      exact[axis] = value + double{transform.column[3][axis]};
    }
    PointDomain domain(&transform, point.data());
    domain.SetRadius(1e-9f);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_LE(std::abs(exact[axis] - double{domain.center()[axis]}), domain.reach()[axis]);
    }
  }
}

// Nearly a similarity, which passes for one: a ball that is a little flat is in a ball all the
// same.
TEST(PointDomainTest, HoldsABallThatIsNoneQuite) {
  Random random(6);
  std::size_t similar = 0;
  for (int round = 0; round < 2000; ++round) {
    TransformStep turned;
    turned.in_parts = true;
    for (float& value : turned.parts.quaternion) value = random.Uniform(-1, 1);
    AffineTransform transform = TransformAt({&turned, 1}, {}, 0);
    const AffineTransform rotation = transform;
    // Lengths and angles off by as much as SimilarityScale allows.
    const auto off = [&] { return random.Next() & 1 ? 0.48e-5f : -0.48e-5f; };
    const float stretch[3][3] = {{0, off(), off()}, {0, off(), off()}, {0, off(), off()}};
    for (int i = 0; i < 3; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        for (int k = 0; k < 3; ++k) {
          transform.column[i][axis] +=
              rotation.column[k][axis] * (stretch[k][i] + (k < i ? 0 : stretch[i][k]) * (k != i));
        }
      }
    }
    if (SimilarityScale(transform) == 0) continue;
    ++similar;
    const float origin[3] = {};
    PointDomain domain(&transform, origin);
    domain.SetRadius(1);
    for (int k = 0; k < 200; ++k) {
      const Float3 way = random.Direction();
      double square = 0, length = 0;
      for (int axis = 0; axis < 3; ++axis) {
        double value = 0;
        for (std::size_t i = 0; i < 3; ++i) value += double{transform.column[i][axis]} * way[i];
        square += value * value;
        length += double{way[static_cast<std::size_t>(axis)]} * way[static_cast<std::size_t>(axis)];
      }
      ASSERT_LE(square / length, domain.square());
    }
  }
  EXPECT_GT(similar, 100u);
}

TEST(SimilarityScale, IsZeroWhereDirectionsDiffer) {
  const auto scaled = [](float x, float y, float z) {
    return AffineTransform{{{x, 0, 0}, {0, y, 0}, {0, 0, z}, {7, 8, 9}}};
  };
  EXPECT_EQ(SimilarityScale(scaled(1, 1, 1)), 1);
  EXPECT_EQ(SimilarityScale(scaled(-3, 3, -3)), 3);
  EXPECT_EQ(SimilarityScale(scaled(1, 1, 1.001f)), 0);
  EXPECT_EQ(SimilarityScale(scaled(kNaN, 1, 1)), 0);
  EXPECT_EQ(SimilarityScale(scaled(1, 1, kNaN)), 0);
  EXPECT_EQ(SimilarityScale({{{1, 0, 0}, {0.001f, 1, 0}, {0, 0, 1}, {0, 0, 0}}}), 0);
  // Whatever the size, as it stands for itself.
  Random random(4);
  for (const float size : {1e-4f, 0.01f, 1.0f, 1000.0f}) {
    for (int i = 0; i < 100; ++i) {
      TransformStep turned;
      turned.in_parts = true;
      for (float& value : turned.parts.scale) value = size;
      for (float& value : turned.parts.quaternion) value = random.Uniform(-1, 1);
      const float scale = SimilarityScale(TransformAt({&turned, 1}, {}, 0));
      EXPECT_NEAR(scale, size, 1e-5f * size);
    }
  }
}

}  // namespace
}  // namespace dacrt
