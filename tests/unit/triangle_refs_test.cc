#include "geometry/triangle_refs.h"

#include <gtest/gtest.h>

#include "unit_test.h"

namespace dacrt {
namespace {

using unit::GuardedArray;
using unit::kInfinity;
using unit::kNaN;
using unit::Mesh;
using unit::Random;

TEST(TriangleRefsTest, BoundsAreThoseOfTheCornersExactly) {
  Random random(1);
  const Mesh mesh = unit::MakeSoup(random, 100, 3, 1);
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});
  for (uint32_t i = 0; i < 100; ++i) {
    TriangleRef ref;
    ASSERT_TRUE(BoundTriangle(table, 0, i, ref));
    EXPECT_EQ(ref.primitive, i);
    EXPECT_EQ(ref.geometry, 0u);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto [lower, upper] =
          std::minmax({mesh.Corner(i, 0)[axis], mesh.Corner(i, 1)[axis], mesh.Corner(i, 2)[axis]});
      EXPECT_EQ(ref.lower[axis], lower);
      EXPECT_EQ(ref.upper[axis], upper);
    }
  }
}

TEST(TriangleRefsTest, TrianglesThatCanNotBeHitAreLeftOut) {
  const float beyond = 1.844e18f, limit = std::nextafter(beyond, 0.0f);
  Mesh mesh;
  mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const float bad : {kNaN, kInfinity, -kInfinity, beyond, -beyond}) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        mesh.vertices[mesh.vertices.size() - 3 + corner][axis] = bad;
      }
    }
  }
  mesh.Add({limit, limit, -limit}, {0, 0, 0}, {-limit, 1, 0});
  const uint32_t vertices = static_cast<uint32_t>(mesh.vertices.size());
  for (const uint32_t bad : {vertices, UINT32_MAX}) {
    mesh.triangles.push_back({bad, 0, 1});
    mesh.triangles.push_back({0, bad, 1});
    mesh.triangles.push_back({0, 1, bad});
  }
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});

  // Room for the two that are left, and not for a byte more.
  GuardedArray<TriangleRef> refs(2);
  const TriangleRange range = MakeTriangleRefs(table, refs);
  ASSERT_EQ(range.begin, 0u);
  ASSERT_EQ(range.end, 2u);
  EXPECT_EQ(refs[0].primitive, 0u);
  EXPECT_EQ(refs[1].primitive, 1u + 5 * 3 * 3);
  EXPECT_EQ(range.bounds.lower[0], -limit);
  EXPECT_EQ(range.bounds.upper[1], limit);
  EXPECT_EQ(range.centers.lower[0], 0);
  EXPECT_EQ(range.centers.upper[0], 1);
}

TEST(TriangleRefsTest, NamesAndBoundsOverAllMeshes) {
  Random random(2);
  std::vector<Mesh> meshes;
  std::vector<TriangleMesh> views;
  for (const uint32_t id : {5u, 1u, 9u}) {
    meshes.push_back(unit::MakeSoup(random, 10 + id, 3, 1));
    meshes.back().geometry_id = id;
  }
  for (const Mesh& mesh : meshes) views.push_back(mesh.View());
  const GeometryTable table(views);
  std::vector<TriangleRef> refs(table.triangle_count());
  const TriangleRange range = MakeTriangleRefs(table, refs);
  ASSERT_EQ(range.count(), refs.size());
  std::size_t i = 0;
  for (uint32_t mesh = 0; mesh < 3; ++mesh) {
    for (uint32_t primitive = 0; primitive < table[mesh].triangle_count; ++primitive, ++i) {
      ASSERT_EQ(refs[i].geometry, mesh);
      ASSERT_EQ(refs[i].primitive, primitive);
    }
  }
  const TriangleRange expected = unit::RangeOf(refs, 0, refs.size());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(range.bounds.lower[axis], expected.bounds.lower[axis]);
    EXPECT_EQ(range.bounds.upper[axis], expected.bounds.upper[axis]);
    EXPECT_EQ(range.centers.lower[axis], expected.centers.lower[axis]);
    EXPECT_EQ(range.centers.upper[axis], expected.centers.upper[axis]);
  }
}

TEST(TriangleRefsTest, NothingToRefer) {
  const GeometryTable table({});
  const TriangleRange range = MakeTriangleRefs(table, {});
  EXPECT_EQ(range.count(), 0u);
  EXPECT_TRUE(range.bounds.IsEmpty());
}

}  // namespace
}  // namespace dacrt
