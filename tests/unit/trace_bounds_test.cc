// Scene::Trace over meshes that cannot be split well: the recursion is bounded.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trace_scene.h"

namespace dacrt::unit {
namespace {

class BoundedTraceTest : public TraceTest {};

INSTANTIATE_ON_EACH_INSTRUCTION_SET(BoundedTraceTest);

constexpr std::size_t kDeepest = 64 + 32;

TEST_P(BoundedTraceTest, EmptyScene) {
  Random random(10);
  const TestScene scene({}, WithInstructionSet());
  auto rays = MakeRays(random, 100, 3);
  const auto before = rays;
  EXPECT_EQ(scene.Trace(rays).hits, 0u);
  ExpectSameRays(rays, before, "no triangles");
  const Bounds bounds = (*scene).bounds();
  EXPECT_EQ(bounds.lower[0], kInfinity);
  EXPECT_EQ(bounds.upper[2], -kInfinity);
  const TestScene invalid({[] {
                            Mesh mesh;
                            mesh.Add({kNaN, 0, 0}, {1, 0, 0}, {0, 1, 0});
                            return mesh;
                          }()},
                          WithInstructionSet());
  EXPECT_EQ((*invalid).triangle_count(), 0u);
  ExpectSameRays(invalid.Traced(before), before, "no triangle that can be hit");
}

TEST_P(BoundedTraceTest, NoRays) {
  Random random(11);
  const TestScene scene(MakeMeshes(random), WithInstructionSet());
  std::vector<Ray> rays(1);
  RayView view = ViewOf(rays);
  view.count = 0;
  EXPECT_EQ((*scene).Trace(Query::kClosest, view).rays, 0u);
}

TEST_P(BoundedTraceTest, SingleTriangle) {
  for (const Settings& settings : VariedSettings()) {
    Mesh mesh;
    mesh.Add({1, -1, -1}, {1, 1, -1}, {1, 0, 1});
    const TestScene scene({mesh}, WithInstructionSet(settings));
    std::vector<Ray> rays(2000, MakeRay({0, 0, 0}, {1, 0, 0}));
    EXPECT_EQ(scene.Trace(rays).hits, 2000u);
    for (const Ray& ray : rays) ASSERT_EQ(ray.tfar, 1);
  }
}

// Concentric triangles of ever larger size, whose centres coincide: no bins tell them apart.
TEST_P(BoundedTraceTest, CoincidentCentroids) {
  Mesh mesh;
  for (int i = 1; i <= 3000; ++i) {
    // The box is symmetric about the origin, so that its centre is it exactly.
    const float s = static_cast<float>(i);
    mesh.Add({-s, -s, -s}, {s, s, -s}, {0, 0, s});
  }
  Random random(12);
  for (const Algorithm algorithm :
       {Algorithm::kNabata2013, Algorithm::kAfra2012, Algorithm::kMora2011}) {
    Settings settings;
    settings.algorithm = algorithm;
    settings.budget = 0;
    const TestScene scene({mesh}, WithInstructionSet(settings));
    auto rays = MakeRays(random, 1500, 1);
    const auto before = rays;
    const Statistics statistics = scene.Trace(rays);
    EXPECT_LE(statistics.max_depth, kDeepest);
    if (algorithm != Algorithm::kMora2011) {
      EXPECT_GT(statistics.median_splits, 0u);
    }
    EXPECT_GT(statistics.hits, 500u);
    // More than fit one subset, so that the grid has to tell them apart, too.
    ExpectSameRays(TestScene({mesh}, WithInstructionSet()).Traced(before), rays, "kept");
  }
}

TEST_P(BoundedTraceTest, IdenticalTriangles) {
  // Every ray has to be tested against each, and names decide between all of them.
  Mesh mesh;
  mesh.vertices = {{1, -1, -1}, {1, 1, -1}, {1, 0, 1}};
  mesh.triangles.assign(20000, {0, 1, 2});
  const TestScene scene({mesh}, WithInstructionSet());
  std::vector<Ray> rays(260, MakeRay({0, 0, 0}, {1, 0, 0}));
  const Statistics statistics = scene.Trace(rays);
  EXPECT_EQ(statistics.hits, 260u);
  EXPECT_LE(statistics.max_depth, kDeepest);
  for (const Ray& ray : rays) {
    ASSERT_EQ(ray.tfar, 1);
    ASSERT_EQ(ray.primitive_id, 0u);
  }
}

// Sizes and distances in a geometric series over the whole range of single precision: splits by
// bins peel off a few triangles at a time.
TEST_P(BoundedTraceTest, GeometricSeries) {
  Mesh mesh;
  for (int i = 0; i < 20000; ++i) {
    const float s = std::exp2(static_cast<float>(i % 100) - 40 + static_cast<float>(i) * 1e-5f);
    mesh.Add({s, -s, -s}, {s, s, -s}, {s, 0, s});
  }
  for (const Algorithm algorithm :
       {Algorithm::kNabata2013, Algorithm::kAfra2012, Algorithm::kMora2011}) {
    Settings settings;
    settings.algorithm = algorithm;
    const TestScene scene({mesh}, WithInstructionSet(settings));
    std::vector<Ray> rays(1100, MakeRay({0, 0, 0}, {1, 0, 0}));
    const Statistics statistics = scene.Trace(rays);
    EXPECT_EQ(statistics.hits, 1100u);
    EXPECT_LE(statistics.max_depth, kDeepest);
    for (const Ray& ray : rays) ASSERT_EQ(ray.primitive_id, 0u);
  }
}

// Two bins peel off one power of two a level; there are more of those than levels by bins.
TEST_P(BoundedTraceTest, DepthIsBounded) {
  Mesh mesh;
  for (int exponent = -40; exponent < 40; ++exponent) {
    for (int i = 0; i < 20; ++i) {
      const float s = std::exp2(static_cast<float>(exponent)) * (1 + static_cast<float>(i) * 1e-3f);
      mesh.Add({s, -s, -s}, {s, s, -s}, {s, 0, s});
    }
  }
  for (const Algorithm algorithm : {Algorithm::kNabata2013, Algorithm::kAfra2012}) {
    Settings settings;
    settings.algorithm = algorithm;
    settings.bins = 2;
    settings.budget = 0;
    const TestScene scene({mesh}, WithInstructionSet(settings));
    std::vector<Ray> rays(1100, MakeRay({0, 0, 0}, {1, 0, 0}));
    const Statistics statistics = scene.Trace(rays);
    EXPECT_GT(statistics.max_depth, 64u);
    EXPECT_LE(statistics.max_depth, 64u + 12u) << "log2 of the number of triangles";
    EXPECT_GT(statistics.median_splits, 0u);
    for (const Ray& ray : rays) ASSERT_EQ(ray.primitive_id, 0u);
  }
}

TEST_P(BoundedTraceTest, DegenerateAndSliverTriangles) {
  Random random(13);
  Mesh mesh;
  for (int i = 0; i < 4000; ++i) {
    const Float3 a = random.InCube(-1, 1), b = random.InCube(-1, 1);
    const float width = i % 3 == 0 ? 0 : std::exp2(random.Uniform(-30, -5));
    mesh.Add(a, b,
             {b[0], b[1] + width, b[2]});  // needles through the whole scene, every third a line
    if (i % 5 == 0) mesh.Add(a, a, a);
  }
  auto before = MakeMixedRays(random, 1500);
  const auto expected = TestScene({mesh}, WithInstructionSet()).Traced(before);
  for (const Algorithm algorithm : {Algorithm::kAfra2012, Algorithm::kMora2011}) {
    Settings settings;
    settings.algorithm = algorithm;
    auto rays = before;
    const Statistics statistics = TestScene({mesh}, WithInstructionSet(settings)).Trace(rays);
    EXPECT_LE(statistics.max_depth, kDeepest);
    ExpectSameRays(rays, expected, std::string(Name(algorithm)));
  }
}

}  // namespace
}  // namespace dacrt::unit
