#include <gtest/gtest.h>

#include <memory>

#include "grazed_slab.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "direct_solve_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "geometry/triangle_refs.h"
#include "paper/direct_solve-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BatchMemory;
using unit::Float3;
using unit::kInfinity;
using unit::Mesh;
using unit::Random;
using unit::Ray;

/// What a ray has after a direct solve: the distance that decides, and the triangle's name.
struct Answer {
  float tfar;
  uint32_t geometry;
  uint32_t primitive;

  bool operator==(const Answer& other) const {
    return memcmp(&tfar, &other.tfar, sizeof(tfar)) == 0 && geometry == other.geometry &&
           primitive == other.primitive;
  }
  bool IsHit() const { return primitive != PaperHit::kNone; }
};

std::ostream& operator<<(std::ostream& out, const Answer& answer) {
  if (!answer.IsHit()) return out << "miss, tfar " << answer.tfar;
  return out << "t " << std::hexfloat << answer.tfar << " geometry " << answer.geometry
             << " primitive " << answer.primitive;
}

/// Meshes, and references to their triangles in an order that a test may change.
class Solver {
 public:
  explicit Solver(std::vector<Mesh> meshes)
      : meshes_(std::move(meshes)),
        scene_{GeometryTable(unit::Views(meshes_))},
        scratch_(std::make_unique<Scratch>()),
        refs(scene_.geometries.triangle_count()) {
    refs.resize(MakeTriangleRefs(scene_.geometries, refs).end);
  }

  /// All rays at once: by rays if there are more of them than triangles.
  template <Query kQuery = Query::kClosest>
  std::vector<Answer> SolveTogether(std::span<const Ray> rays) {
    return Solve<kQuery>(rays, rays.size(), refs.size());
  }

  /// A ray at a time: by triangles.
  template <Query kQuery = Query::kClosest>
  std::vector<Answer> SolveAlone(std::span<const Ray> rays) {
    return Solve<kQuery>(rays, 1, refs.size());
  }

  /// One triangle after the other, as if each were a leaf.
  std::vector<Answer> SolveTriangleByTriangle(std::span<const Ray> rays) {
    return Solve<Query::kClosest>(rays, rays.size(), 1);
  }

  const Mesh& mesh(size_t i) const { return meshes_[i]; }

 private:
  /// Blocks of `block_rays` rays, each against leaves of `leaf_triangles` triangles.
  template <Query kQuery>
  std::vector<Answer> Solve(std::span<const Ray> rays, size_t block_rays, size_t leaf_triangles) {
    BatchMemory memory(
        hwy::DivCeil(rays.size(), block_rays) * hwy::RoundUpTo(block_rays, kMaxLanes) + kMaxLanes,
        rays.size());
    const Settings settings;
    const RayView no_view;
    const CallOptions options;
    const CallFrame frame{&no_view, nullptr, 0, options, UINT32_MAX};
    const PaperTask task{scene_,    settings,   refs,   memory.batch,
                         *scratch_, statistics, clock_, frame};
    std::vector<Answer> answers;
    for (size_t first = 0; first < rays.size(); first += block_rays) {
      const RayBlock block = memory.Push(rays.subspan(first, block_rays), first);
      for (size_t i = 0; i < refs.size(); i += leaf_triangles) {
        SolveDirect<kQuery>(task, unit::RangeOf(refs, i, i + leaf_triangles), block);
      }
      for (size_t i = 0; i < block_rays; ++i) {
        // PaperHit::kAtLimit is the engine's own.
        const PaperHit& hit = memory.batch.hits[first + i];
        const uint32_t mesh =
            hit.primitive == PaperHit::kNone ? hit.geometry : hit.geometry & ~PaperHit::kAtLimit;
        answers.push_back({memory.batch.tfar[block.begin + i], mesh, hit.primitive});
      }
    }
    return answers;
  }

  std::vector<Mesh> meshes_;
  SceneParts scene_;
  std::unique_ptr<Scratch> scratch_;
  StepClock clock_;

 public:
  std::vector<TriangleRef> refs;
  Statistics statistics;
};

void Shuffle(Random& random, std::vector<TriangleRef>& refs) {
  for (size_t i = refs.size(); i > 1; --i) {
    std::swap(refs[i - 1], refs[random.Below(static_cast<uint32_t>(i))]);
  }
}

/// The same answers in every order and grouping, and any-hit agrees with closest hit.
void ExpectIndependenceOfOrder(Random& random, Solver& solver, std::span<const Ray> rays) {
  const auto expected = solver.SolveTogether(rays);
  for (int round = 0; round < 4; ++round) {
    Shuffle(random, solver.refs);
    const auto together = solver.SolveTogether(rays);
    const auto alone = solver.SolveAlone(rays);
    const auto by_triangle = solver.SolveTriangleByTriangle(rays);
    const auto blocked = solver.SolveTogether<Query::kAny>(rays);
    const auto blocked_alone = solver.SolveAlone<Query::kAny>(rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(together[i], expected[i]) << "ray " << i;
      ASSERT_EQ(alone[i], expected[i]) << "ray " << i;
      ASSERT_EQ(by_triangle[i], expected[i]) << "ray " << i;
      ASSERT_EQ(blocked[i].tfar < 0, expected[i].IsHit()) << "ray " << i;
      ASSERT_EQ(blocked_alone[i].tfar < 0, expected[i].IsHit()) << "ray " << i;
      ASSERT_FALSE(blocked[i].IsHit()) << "an any-hit query names no hit";
    }
  }
}

// Against Moeller-Trumbore in double precision, for pairs that rounding can not decide otherwise.
void MatchesDoublePrecision() {
  Random random(1);
  size_t hits = 0;
  for (const size_t triangles : {1u, 5u, 8u, 63u, 64u, 65u, 200u}) {
    Solver solver({unit::MakeSoup(random, triangles, 1, 1)});
    auto rays = unit::MakeRays(random, 300, 2);
    for (Ray& ray : rays) {
      if (random.Below(3) == 0) ray.tnear = random.Uniform(0, 1);
      if (random.Below(3) == 0) ray.tfar = random.Uniform(1, 3);
      const float length = std::exp2(random.Uniform(-10, 10));
      for (float& x : ray.dir) x *= length;
      ray.tnear /= length;
      ray.tfar /= length;
    }
    const auto answers = solver.SolveTogether(rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      double least = kInfinity;
      size_t least_triangle = SIZE_MAX;
      bool clear = true;
      for (size_t triangle = 0; triangle < triangles; ++triangle) {
        const unit::ExactHit exact = unit::IntersectExactly(rays[i], solver.mesh(0), triangle);
        const double slack = 1e-4 * std::abs(exact.t);
        clear &= !(std::abs(exact.inside) < 1e-3) && !(std::abs(exact.t - rays[i].tnear) < slack) &&
                 !(std::abs(exact.t - rays[i].tfar) < slack) &&
                 !(std::abs(exact.t - least) < slack);
        if (exact.inside < 0 || exact.t <= rays[i].tnear || exact.t > rays[i].tfar) continue;
        if (exact.t < least) {
          least = exact.t;
          least_triangle = triangle;
        }
      }
      if (!clear) continue;
      ASSERT_EQ(answers[i].IsHit(), least_triangle != SIZE_MAX) << "ray " << i;
      if (!answers[i].IsHit()) {
        ASSERT_EQ(answers[i].tfar, rays[i].tfar);
        continue;
      }
      ++hits;
      const unit::ExactHit exact = unit::IntersectExactly(rays[i], solver.mesh(0), least_triangle);
      ASSERT_EQ(answers[i].primitive, least_triangle);
      ASSERT_NEAR(answers[i].tfar, exact.t, 1e-3 * exact.t);
    }
  }
  EXPECT_GT(hits, 250u);
}

void OrderAndGroupingDoNotMatter() {
  Random random(2);
  for (const size_t triangles : {2u, 9u, 64u, 70u}) {
    Solver solver({unit::MakeSoup(random, triangles, 1, 2)});
    ExpectIndependenceOfOrder(random, solver, unit::MakeRays(random, 75, 2));
  }
}

// A distance that was moved into the box for comparing, and not for the depth test against
// what had been found before, made the hit depend on the order.
void OrderDoesNotMatterFarAwayAtGrazingAngles() {
  Random random(3);
  for (int round = 0; round < 400; ++round) {
    unit::GrazedSlab slab(random);
    Mesh mesh;
    for (int i = 0; i < 20; ++i) mesh.Add(slab.Point(), slab.Point(), slab.Point());
    std::vector<Ray> rays;
    for (int i = 0; i < 40; ++i) {
      rays.push_back(slab.MakeGrazingRay());
      if (i % 4 == 0) rays.back().tfar = random.Uniform(0.999f, 1.001f);
    }
    Solver solver({mesh});
    ExpectIndependenceOfOrder(random, solver, rays);
    if (testing::Test::HasFatalFailure()) return;
  }
}

/// Triangles in the plane x = 1, all of which the ray (0,0,0) + t (1,0,0) hits at t = 1.
Mesh TrianglesAtOne(size_t count, uint32_t geometry_id) {
  Mesh mesh;
  mesh.geometry_id = geometry_id;
  for (size_t i = 0; i < count; ++i) {
    const float size = static_cast<float>(i + 1);
    mesh.Add({1, -size, -size}, {1, size, -size}, {1, 0, size});
  }
  return mesh;
}

void AmongEqualDistancesTheSmallestNameWins() {
  Random random(4);
  // Given in another order than that of their IDs, by which the table sorts them.
  Solver solver({TrianglesAtOne(40, 9), TrianglesAtOne(3, 2), TrianglesAtOne(40, 5)});
  const std::vector<Ray> rays(17, unit::MakeRay({0, 0, 0}, {1, 0, 0}));
  for (int round = 0; round < 20; ++round) {
    Shuffle(random, solver.refs);
    for (const auto& answers : {solver.SolveTogether(rays), solver.SolveAlone(rays)}) {
      for (const Answer& answer : answers) {
        ASSERT_EQ(answer.tfar, 1);
        ASSERT_EQ(answer.geometry, 0u);
        ASSERT_EQ(answer.primitive, 0u);
      }
    }
  }
}

// tnear < t <= tfar, exactly.
void TheIntervalIsOpenAtTNearAndClosedAtTFar() {
  Solver solver({TrianglesAtOne(5, 0)});
  const float below = std::nextafter(1.0f, 0.0f), above = std::nextafter(1.0f, 2.0f);
  struct Case {
    float tnear, tfar;
    bool hits;
  };
  const Case cases[] = {{0, 1, true},          {0, below, false}, {0, above, true},
                        {1, kInfinity, false}, {below, 1, true},  {below, above, true},
                        {above, 2, false},     {1, 1, false},     {-kInfinity, kInfinity, true},
                        {-5, 1, true},         {-5, -0.0f, false}};
  for (const Case& c : cases) {
    const std::vector<Ray> rays(19, unit::MakeRay({0, 0, 0}, {1, 0, 0}, c.tnear, c.tfar));
    for (const auto& answers : {solver.SolveTogether(rays), solver.SolveAlone(rays)}) {
      for (const Answer& answer : answers) {
        ASSERT_EQ(answer.IsHit(), c.hits) << c.tnear << " to " << c.tfar;
        if (c.hits) {
          ASSERT_EQ(answer.tfar, 1);
        } else {
          ASSERT_EQ(answer.tfar, c.tfar);
        }
      }
    }
    for (const Answer& answer : solver.SolveTogether<Query::kAny>(rays)) {
      ASSERT_EQ(answer.tfar == -kInfinity, c.hits);
    }
  }
}

// A ray that ends at the hit, or a rounding before or behind it: of coincident triangles the
// smallest name wins there too, and a closer one beats all. T may be within |den| tfar although
// T / |den| rounds to a number above tfar.
void HitsAtTheRaysEndDoNotDependOnTheOrder() {
  Random random(5);
  size_t at_end = 0;
  for (int round = 0; round < 60; ++round) {
    Mesh mesh;
    Float3 corner[3];
    for (auto& c : corner) c = random.InCube(-1, 1);
    for (int i = 0; i < 4; ++i) mesh.Add(corner[0], corner[1], corner[2]);
    // Nearly coincident ones: the same plane to a rounding.
    for (int i = 0; i < 4; ++i) {
      for (auto& c : corner) c[random.Below(3)] *= 1 + 0x1p-23f * random.Uniform(-2, 2);
      mesh.Add(corner[0], corner[1], corner[2]);
    }
    Solver solver({mesh});
    std::vector<Ray> rays;
    for (int i = 0; i < 30; ++i) {
      Float3 target{};
      const float u = random.Uniform(0, 0.5f), v = random.Uniform(0, 0.5f);
      const Float3 org = random.InCube(-3, 3);
      for (size_t axis = 0; axis < 3; ++axis) {
        target[axis] = corner[0][axis] + u * (corner[1][axis] - corner[0][axis]) +
                       v * (corner[2][axis] - corner[0][axis]) - org[axis];
      }
      const float length = random.Uniform(0.3f, 3);
      for (float& x : target) x *= length;
      rays.push_back(unit::MakeRay(org, target));
    }
    const auto open = solver.SolveTogether(rays);
    std::vector<Ray> ending;
    for (size_t i = 0; i < rays.size(); ++i) {
      if (!open[i].IsHit()) continue;
      float tfar = open[i].tfar;
      for (int k = 0; k < 2; ++k) tfar = std::nextafter(tfar, 0.0f);
      for (int k = 0; k < 5; ++k) {
        ending.push_back(rays[i]);
        ending.back().tfar = tfar;
        tfar = std::nextafter(tfar, kInfinity);
      }
    }
    if (ending.empty()) continue;
    ExpectIndependenceOfOrder(random, solver, ending);
    if (testing::Test::HasFatalFailure()) return;
    const auto answers = solver.SolveTogether(ending);
    for (size_t i = 0; i < ending.size(); ++i) {
      if (!answers[i].IsHit()) continue;
      ASSERT_LE(answers[i].tfar, ending[i].tfar);
      at_end += answers[i].tfar == ending[i].tfar;
    }
  }
  EXPECT_GT(at_end, 1000u);
}

void MasksDecideWhoMeetsWhom() {
  Mesh near = TrianglesAtOne(2, 0), far = TrianglesAtOne(2, 1);
  for (Float3& vertex : far.vertices) vertex[0] = 2;
  near.mask = 0b0011;
  far.mask = 0b0110;
  Solver solver({near, far});
  struct Case {
    uint32_t mask;
    float tfar;
  };
  const Case cases[] = {{0b0001, 1}, {0b0010, 1}, {0b0100, 2}, {0b0111, 1}, {0b1000, kInfinity}};
  for (const Case& c : cases) {
    Ray ray = unit::MakeRay({0, 0, 0}, {1, 0, 0});
    ray.mask = c.mask;
    const std::vector<Ray> rays(5, ray);
    for (const Answer& answer : solver.SolveTogether(rays)) EXPECT_EQ(answer.tfar, c.tfar);
    for (const Answer& answer : solver.SolveAlone(rays)) EXPECT_EQ(answer.tfar, c.tfar);
    for (const Answer& answer : solver.SolveTogether<Query::kAny>(rays)) {
      EXPECT_EQ(answer.tfar == -kInfinity, c.tfar != kInfinity);
    }
  }
}

void BothSidesAreHit() {
  Mesh mesh;
  mesh.Add({1, 0, 0}, {1, 1, 0}, {1, 0, 1});
  Solver solver({mesh});
  const std::vector<Ray> rays = {
      unit::MakeRay({0, 0.25f, 0.5f}, {1, 0, 0}), unit::MakeRay({2, 0.25f, 0.5f}, {-1, 0, 0}),
      unit::MakeRay({0, 0.25f, 0.5f}, {-1, 0, 0}), unit::MakeRay({2, 0.25f, 0.5f}, {1, 0, 0})};
  const auto answers = solver.SolveTogether(rays);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(answers[i].tfar, 1);
  }
  EXPECT_FALSE(answers[2].IsHit()) << "behind the origin";
  EXPECT_FALSE(answers[3].IsHit()) << "behind the origin";
}

void DegenerateTrianglesAreNotHit() {
  Mesh mesh;
  mesh.Add({1, 0, 0}, {1, 0, 0}, {1, 0, 0});   // a point
  mesh.Add({1, -1, 0}, {1, 1, 0}, {1, 0, 0});  // a line
  mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});   // parallel to the rays below
  Solver solver({mesh});
  std::vector<Ray> rays(20, unit::MakeRay({0, 0, 0}, {1, 0, 0}));
  for (const Answer& answer : solver.SolveTogether(rays)) EXPECT_FALSE(answer.IsHit());
  for (const Answer& answer : solver.SolveAlone(rays)) EXPECT_FALSE(answer.IsHit());
}

void WorkIsCounted() {
  Random random(6);
  Solver solver({unit::MakeSoup(random, 70, 1, 1)});
  solver.SolveTogether(unit::MakeRays(random, 11, 1));
  EXPECT_EQ(solver.statistics.direct_solves, 1u);
  EXPECT_EQ(solver.statistics.direct_rays, 11u);
  EXPECT_EQ(solver.statistics.triangle_tests, 11u * 70u);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(DirectSolveTest);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, MatchesDoublePrecision);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, OrderAndGroupingDoNotMatter);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, OrderDoesNotMatterFarAwayAtGrazingAngles);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, AmongEqualDistancesTheSmallestNameWins);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, TheIntervalIsOpenAtTNearAndClosedAtTFar);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, HitsAtTheRaysEndDoNotDependOnTheOrder);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, MasksDecideWhoMeetsWhom);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, BothSidesAreHit);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, DegenerateTrianglesAreNotHit);
HWY_EXPORT_AND_TEST_P(DirectSolveTest, WorkIsCounted);

}  // namespace dacrt
#endif  // HWY_ONCE
