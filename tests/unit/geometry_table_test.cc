#include "geometry/geometry_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "unit_test.h"

namespace dacrt {
namespace {

using unit::GuardedArray;
using unit::Mesh;

std::string MessageOf(const TriangleMesh& mesh) {
  const TriangleMesh good = {};
  const TriangleMesh meshes[] = {good, mesh};
  try {
    const GeometryTable table(meshes);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(GeometryTableTest, SortsByGeometryIdAndKeepsTheOrderOfEqualOnes) {
  Mesh mesh;
  mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  std::vector<TriangleMesh> views(5, mesh.View());
  const uint32_t ids[] = {7, 3, UINT32_MAX, 3, 0};
  for (std::size_t i = 0; i < 5; ++i) {
    views[i].geometry_id = ids[i];
    views[i].mask = static_cast<uint32_t>(i);
  }
  const GeometryTable table(views);
  const uint32_t expected_masks[] = {4, 1, 3, 0, 2};
  for (uint32_t i = 0; i < 5; ++i) EXPECT_EQ(table[i].mask, expected_masks[i]);
  EXPECT_EQ(table.triangle_count(), 5u);
}

TEST(GeometryTableTest, FindsTheOnlyGeometryWithAnId) {
  const auto expect = [](const std::vector<uint32_t>& ids) {
    std::vector<TriangleMesh> views(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) views[i].geometry_id = ids[i];
    const GeometryTable table(views);
    for (const uint32_t id : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, UINT32_MAX}) {
      const auto found = table.Find(id);
      ASSERT_EQ(found.has_value(), std::count(ids.begin(), ids.end(), id) == 1) << id;
      if (found) {
        EXPECT_EQ(table[*found].geometry_id, id);
      }
    }
  };
  expect({});
  expect({5});
  expect({2, 3, 4, 5, 6});
  expect({2, 3, 4, 5, 6, UINT32_MAX});
  expect({1, 3, 4, 4, 5, 7});
  expect({1, 1, 3, 4, 5, 5});
  expect({0, 0, 0, 3, 4});
}

TEST(GeometryTableTest, LocatesTrianglesByTheirNumbers) {
  const auto expect = [](const std::vector<std::size_t>& counts) {
    Mesh mesh;
    for (int i = 0; i < 3; ++i) mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    std::vector<TriangleMesh> views(counts.size(), mesh.View());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      views[i].geometry_id = static_cast<uint32_t>(i);
      views[i].triangle_count = counts[i];
    }
    const GeometryTable table(views);
    uint32_t number = 0;
    for (uint32_t geometry = 0; geometry < counts.size(); ++geometry) {
      for (uint32_t i = 0; i < counts[geometry]; ++i, ++number) {
        const GeometryTable::Name name = table.Locate(number);
        EXPECT_EQ(name.geometry, geometry) << number;
        EXPECT_EQ(name.primitive, i) << number;
        EXPECT_EQ(table.Number(name.geometry, name.primitive), number);
      }
    }
  };
  expect({1, 1, 1, 1});
  expect({1, 1, 2, 1});
  expect({1, 0, 2, 1});
  expect({0, 1, 1});
  expect({3});
}

TEST(GeometryTableTest, KnowsWhetherMasksCanBeIgnored) {
  TriangleMesh views[2];
  EXPECT_TRUE(GeometryTable(views).all_masks_full());
  views[1].mask = 0x7FFFFFFF;
  EXPECT_FALSE(GeometryTable(views).all_masks_full());
}

TEST(GeometryTableTest, EmptyMeshesNeedNoMemory) {
  const TriangleMesh empty[3] = {};
  EXPECT_EQ(GeometryTable(empty).triangle_count(), 0u);
  EXPECT_EQ(GeometryTable({}).triangle_count(), 0u);
}

TEST(GeometryTableTest, RefusesMissingAndMisplacedArrays) {
  Mesh mesh;
  mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const TriangleMesh good = mesh.View();
  EXPECT_EQ(MessageOf(good), "");
  const auto moved = [](const void* p) { return static_cast<const char*>(p) + 1; };
  const auto expect = [](const TriangleMesh& bad, const std::string& array) {
    TriangleMesh named = bad;
    named.geometry_id = 31;
    const std::string message = MessageOf(named);
    EXPECT_NE(message.find("geometry 31"), std::string::npos) << message;
    EXPECT_NE(message.find(array), std::string::npos) << message;
  };
  TriangleMesh bad = good;
  bad.vertices = nullptr;
  expect(bad, "vertices");
  bad = good;
  bad.triangles = nullptr;
  expect(bad, "triangles");
  bad = good;
  bad.vertices = moved(good.vertices);
  expect(bad, "vertices");
  bad = good;
  bad.triangles = moved(good.triangles);
  expect(bad, "triangles");
  bad = good;
  bad.vertex_stride = 14;
  expect(bad, "14");
  bad = good;
  bad.triangle_stride = 13;
  expect(bad, "13");
}

TEST(GeometryTableTest, RefusesTooManyTriangles) {
  Mesh mesh;
  mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  std::vector<TriangleMesh> views(2, mesh.View());
  views[0].triangle_count = 0x40000000u;
  views[1].triangle_count = 0x3FFFFFFEu;
  EXPECT_EQ(GeometryTable(views).triangle_count(), 0x7FFFFFFEu);
  views[1].triangle_count = 0x3FFFFFFFu;
  EXPECT_THROW(GeometryTable{views}, Error);
}

// The counts of 64 bits add up to 0.
TEST(GeometryTableTest, RefusesTooManyTrianglesAlsoWhereTheirSumOverflows) {
  Mesh mesh;
  mesh.Add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  std::vector<TriangleMesh> views(2, mesh.View());
  for (TriangleMesh& view : views) view.triangle_count = std::size_t{1} << 63;
  EXPECT_THROW(GeometryTable{views}, Error);
}

TEST(GeometryTableTest, ReadsStridedArraysThatEndAtAGuardPage) {
  for (const std::size_t stride : {12u, 16u, 20u, 64u}) {
    GuardedArray<char> vertices(3 * stride + 12, 4), triangles(2 * stride + 12, 4);
    TriangleMesh view;
    view.vertices = vertices.end() - (3 * stride + 12);
    view.vertex_stride = stride;
    view.vertex_count = 4;
    view.triangles = triangles.end() - (2 * stride + 12);
    view.triangle_stride = stride;
    view.triangle_count = 3;
    for (std::size_t i = 0; i < 4; ++i) {
      const float vertex[3] = {static_cast<float>(i), 10.0f + static_cast<float>(i), -1};
      std::memcpy(const_cast<char*>(static_cast<const char*>(view.vertices)) + i * stride, vertex,
                  sizeof(vertex));
    }
    const uint32_t indices[3][3] = {{0, 1, 2}, {3, 0, 1}, {3, 3, 4}};
    for (std::size_t i = 0; i < 3; ++i) {
      std::memcpy(const_cast<char*>(static_cast<const char*>(view.triangles)) + i * stride,
                  indices[i], sizeof(indices[i]));
    }
    const GeometryTable table({&view, 1});
    Corners corners;
    ASSERT_TRUE(table.ReadCorners(0, 1, corners));
    EXPECT_EQ(corners.v[0][0], 3);
    EXPECT_EQ(corners.v[1][1], 10);
    EXPECT_EQ(corners.v[2][0], 1);
    EXPECT_FALSE(table.ReadCorners(0, 2, corners)) << "index 4 of 4 vertices";
  }
}

/// Facets of one geometry with six vertices, in memory that holds one more.
class FacetsTest : public testing::Test {
 protected:
  /// Whether the first facet is there, when the program has written `primitive` into an array that
  /// was good when the table was made.
  template <class Primitive>
  bool IsThere(Shape shape, Primitive good, const Primitive& primitive) const {
    Geometry geometry;
    geometry.shape = shape;
    geometry.primitive_count = 1;
    geometry.vertices = {{vertices_, 12}};
    geometry.vertex_count = 6;
    geometry.primitives = {&good, sizeof(good)};
    const SceneParts* const no_scene = nullptr;
    const GeometryTable table({&geometry, 1}, {&no_scene, 1}, true);
    good = primitive;
    Facet facet;
    return table.shapes().ReadFacet(0, 0, 0, facet);
  }

  float vertices_[7][3] = {};
};

TEST_F(FacetsTest, IndicesEndAtTheLastVertex) {
  using Three = std::array<uint32_t, 3>;
  using Four = std::array<uint32_t, 4>;
  EXPECT_TRUE(IsThere(Shape::kTriangles, Three{}, {5, 0, 1}));
  EXPECT_FALSE(IsThere(Shape::kTriangles, Three{}, {6, 0, 1}));
  EXPECT_FALSE(IsThere(Shape::kTriangles, Three{}, {0, 1, 6}));
  EXPECT_TRUE(IsThere(Shape::kQuads, Four{}, {0, 1, 2, 5}));
  EXPECT_FALSE(IsThere(Shape::kQuads, Four{}, {0, 1, 2, 6}));
}

TEST_F(FacetsTest, ACellOfAGridEndsAtTheLastVertex) {
  const GridPrimitive good{0, 3, 3, 2};
  EXPECT_TRUE(IsThere(Shape::kGrids, good, {1, 3, 3, 2}));
  EXPECT_FALSE(IsThere(Shape::kGrids, good, {2, 3, 3, 2}));
  EXPECT_TRUE(IsThere(Shape::kGrids, good, {0, 4, 3, 2}));
  EXPECT_FALSE(IsThere(Shape::kGrids, good, {0, 5, 3, 2}));
}

}  // namespace
}  // namespace dacrt
