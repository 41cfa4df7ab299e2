// What says that a partition may be taken over, and what in it has changed.
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "geometry/geometry_table.h"
#include "partition/refit.h"

namespace dacrt {
namespace {

/// Two triangles of four vertices, with others beside them to point to.
struct Arrays {
  float vertices[8][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                          {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
  uint32_t indices[4][3] = {{0, 1, 2}, {1, 2, 3}, {0, 1, 2}, {1, 2, 3}};
};

using Change = std::function<void(Geometry&)>;

class RefitItemsTest : public testing::Test {
 protected:
  Geometry Plain() const {
    Geometry geometry;
    geometry.revision = 7;
    geometry.primitive_count = 2;
    geometry.vertices = {{arrays_.vertices, 12}};
    geometry.vertex_count = 4;
    geometry.primitives = {arrays_.indices, 12};
    return geometry;
  }

  static GeometryTable TableOf(const Geometry& geometry) {
    const SceneParts* const no_scene = nullptr;
    return GeometryTable({&geometry, 1}, {&no_scene, 1}, false);
  }

  bool AreSameItems(const Change& change) const {
    Geometry geometry = Plain();
    change(geometry);
    return BeginsWithSameItems(TableOf(Plain()), TableOf(geometry));
  }

  bool MayDiffer(const Change& change) const {
    Geometry geometry = Plain();
    change(geometry);
    return IsChanged(Plain(), geometry);
  }

  Arrays arrays_;
};

TEST_F(RefitItemsTest, OtherItemsAreTold) {
  EXPECT_TRUE(AreSameItems([](Geometry&) {}));
  EXPECT_FALSE(AreSameItems([](Geometry& g) { g.primitive_count = 1; }));
  EXPECT_FALSE(AreSameItems([](Geometry& g) { g.geometry_id = 1; }));
  EXPECT_FALSE(AreSameItems([&](Geometry& g) { g.primitives.data = arrays_.indices[2]; }));
  EXPECT_FALSE(AreSameItems([](Geometry& g) { g.vertices.push_back(g.vertices.front()); }));
}

TEST_F(RefitItemsTest, WhatMovedIsTold) {
  EXPECT_FALSE(MayDiffer([](Geometry&) {}));
  EXPECT_TRUE(MayDiffer([](Geometry& g) { g.revision = 8; }));
  EXPECT_TRUE(MayDiffer([](Geometry& g) { g.revision = 0; }));
  EXPECT_TRUE(MayDiffer([](Geometry& g) { g.vertex_count = 3; }));
  EXPECT_TRUE(MayDiffer([&](Geometry& g) { g.vertices.front().data = arrays_.vertices[4]; }));
}

}  // namespace
}  // namespace dacrt
