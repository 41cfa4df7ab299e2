#include <gtest/gtest.h>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kept_partition_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "kept_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Float3;
using unit::Random;

/// With all the room that a partition can want.
Counts ExpectWholePartition(std::vector<Mesh> meshes, const std::string& what) {
  SCOPED_TRACE(what);
  Counts counts[std::size(kAllRays)];
  for (const Rays rays : kAllRays) {
    Kept kept(meshes, kPlenty);
    kept.rays = rays;
    Walker walker(kept);
    walker.Walk(true);
    EXPECT_TRUE(rays == Rays::kFew || walker.rented == 0);
    counts[static_cast<size_t>(rays)] = walker;
  }
  const auto [few, many, more, cared] = counts;
  EXPECT_LE(few.nodes, 2 * many.nodes + 2);
  EXPECT_LE(few.leaves, 2 * many.leaves);
  EXPECT_EQ(more.nodes, many.nodes);
  EXPECT_EQ(more.leaves, many.leaves);
  EXPECT_LE(cared.nodes, 2 * many.nodes + 2);
  EXPECT_LE(cared.leaves, 2 * many.leaves);
  return many;
}

// Around the sizes at which leaves, nodes, subsets and the grid begin.
void PartitionsOfEverySize() {
  Random random(1);
  for (const size_t count : {1u,  2u,  3u,  4u,  5u,   8u,    11u,   12u,   13u,   14u,   24u,
                             25u, 33u, 96u, 97u, 500u, 2047u, 2048u, 2049u, 2100u, 5000u, 20000u}) {
    ExpectWholePartition({unit::MakeSoup(random, count, 1, 0.1f)}, std::to_string(count));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Few bytes a triangle hold it all: nodes are not stacked without need.
void TakesFewBytes() {
  Random random(2);
  constexpr size_t kTriangles = 50000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.05f);
  Kept kept({mesh}, kPlenty), compressed({mesh}, 24 * kTriangles);
  Walker walker(kept);
  walker.Walk(true);
  Walker(compressed).Walk(true);
  // Four bytes of order, and the nodes, exact or not.
  EXPECT_LT(kept.partition.BytesUsed(), 16 * kTriangles);
  EXPECT_LT(compressed.partition.BytesUsed(), 10 * kTriangles);
  EXPECT_GT(walker.subsets, kTriangles / SubsetScratch::kTriangles);
  EXPECT_LT(walker.leaves, kTriangles / 3);
  EXPECT_GT(walker.children, 3 * walker.nodes);
  EXPECT_LT(walker.deepest, 16u);
}

void TrianglesThatCoincide() {
  Mesh same;
  same.vertices = {{1, -1, -1}, {1, 1, -1}, {1, 0, 1}};
  for (const size_t count : {13u, 5000u, 70000u}) {
    same.triangles.assign(count, {0, 1, 2});
    ExpectWholePartition({same}, "identical " + std::to_string(count));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Boxes around one point, of 100,000 sizes: the grid can only tell them apart by their order.
void TrianglesAroundOnePoint() {
  Mesh mesh;
  for (int i = 1; i <= 100000; ++i) {
    const float s = static_cast<float>(i);
    mesh.Add({-s, -s, -s}, {s, s, -s}, {0, 0, s});
  }
  const Counts counts = ExpectWholePartition({mesh}, "one centre");
  EXPECT_LT(counts.deepest, 40u);
}

// Points, lines, and centres that differ on one axis only, by next to nothing.
void DegenerateTriangles() {
  Random random(3);
  Mesh points, line, close;
  for (int i = 0; i < 6000; ++i) {
    const Float3 p = random.InCube(-1, 1);
    points.Add(p, p, p);
    const float x = static_cast<float>(i);
    line.Add({x, 0, 0}, {x + 1, 0, 0}, {x, 0, 0});
    const float y = 1 + static_cast<float>(i % 5) * 0x1p-23f;
    close.Add({0, y, 0}, {1, y, 0}, {0, y, 1});
  }
  ExpectWholePartition({points}, "points");
  ExpectWholePartition({line}, "a line");
  ExpectWholePartition({close}, "next to each other");
}

// Nearly all triangles in one cell of the first grid, and in one of the next.
void TeapotInAStadium() {
  Random random(4);
  for (const float size : {1e-3f, 1e-6f}) {
    Mesh stadium = unit::MakeSoup(random, 300, 1000, 100), teapot, spout;
    for (const auto& [mesh, count, extent] :
         {std::tuple<Mesh*, size_t, float>{&teapot, 15000, 1}, {&spout, 15000, size}}) {
      *mesh = unit::MakeSoup(random, count, extent, extent * 0.02f);
    }
    teapot.geometry_id = 1;
    spout.geometry_id = 2;
    ExpectWholePartition({stadium, teapot, spout}, "teapot");
    if (testing::Test::HasFatalFailure()) return;
  }
}

// From the least to the largest that can be hit, in a geometric series.
void ScalesOfAllKinds() {
  Mesh series;
  for (int i = 0; i < 20000; ++i) {
    const float s = std::exp2(static_cast<float>(i % 100) - 40 + static_cast<float>(i) * 1e-5f);
    if (s > 1e18f) continue;
    series.Add({s, -s, -s}, {s, s, -s}, {s, 0, s});
  }
  ExpectWholePartition({series}, "series");
  Random random(5);
  for (const float extent : {1e-25f, 1e-19f, 1e-6f, 1e6f, 1.7e18f}) {
    ExpectWholePartition({unit::MakeSoup(random, 5000, extent, extent * 0.01f)},
                         std::to_string(extent));
    if (testing::Test::HasFatalFailure()) return;
  }
}

// Those that no ray can hit are in no subset.
void InvalidTrianglesAreLeftOut() {
  Random random(6);
  Mesh first = unit::MakeSoup(random, 4000, 1, 0.1f), second = unit::MakeSoup(random, 900, 1, 0.1f);
  second.geometry_id = 7;
  size_t invalid = 0;
  for (size_t i = 0; i < 4000; i += 3, ++invalid) {
    switch (i % 4) {
      case 0:
        first.triangles[i][random.Below(3)] = 12000;
        break;
      case 1:
        first.vertices[3 * i + random.Below(3)][random.Below(3)] = unit::kNaN;
        break;
      case 2:
        first.vertices[3 * i + random.Below(3)][random.Below(3)] = -unit::kInfinity;
        break;
      default:
        first.vertices[3 * i + random.Below(3)][random.Below(3)] = 2e18f;
    }
  }
  Kept kept({first, second}, kPlenty);
  EXPECT_EQ(kept.partition.triangle_count(), 4900 - invalid);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(kept.partition.bounds().lower[axis], -1.2f);
    EXPECT_LT(kept.partition.bounds().upper[axis], 1.2f);
  }
  Walker(kept).Walk(true);
}

// Threads list a piece each; what each leaves out was overwritten by what the next one kept.
void TheNamesOfThoseLeftOutAreKept() {
  Random random(8);
  constexpr size_t kTriangles = 140000;  // three pieces
  Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.05f);
  std::vector<uint32_t> left_out;
  for (size_t i = 100; i < kTriangles; i += 30000) {
    mesh.triangles[i][0] = UINT32_MAX;
    left_out.push_back(static_cast<uint32_t>(i));
  }
  const Kept kept({mesh}, 8 * kTriangles);
  std::vector<uint32_t> names(kept.partition.left_out().begin(), kept.partition.left_out().end());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, left_out);
}

// With any budget every subset finds room for nodes over leaves that are as large as it takes;
// where others took it those that find none stay whole. What is used is within the budget.
//
// With five bytes a triangle there were nodes for half of the subsets, and of the others every
// triangle was tested: rays took a hundred times as long as with eight.
void TheBudgetIsNeverExceeded() {
  Random random(7);
  constexpr size_t kTriangles = 12000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.05f);
  const size_t least = KeptPartition::LeastBytes(kTriangles);
  EXPECT_LT(least, 6 * kTriangles);
  size_t last_nodes = 0;
  for (const size_t budget :
       {size_t{0}, least - 1, least, least + 100, least + 3000, 6 * kTriangles, least + 5000,
        least + 8000, least + 12000, 7 * kTriangles, 16 * kTriangles}) {
    SCOPED_TRACE(budget);
    Kept kept({mesh}, budget);
    EXPECT_LE(kept.partition.BytesReserved(), std::max(least, budget));
    EXPECT_GT(kept.partition.BytesReserved() + KeptPartition::kLeafUnit, std::max(least, budget));
    Walker walker(kept);
    walker.Walk(false);
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_EQ(walker.without_room, 0u);
    EXPECT_GE(walker.nodes, last_nodes) << "more room, more nodes";
    last_nodes = walker.nodes;

    Kept cared({mesh}, budget);
    cared.rays = Rays::kExpected;
    Walker cared_walker(cared);
    cared_walker.Walk(false);
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_EQ(cared_walker.without_room, 0u);

    Kept narrow({mesh}, budget);
    uint32_t first_node, first_subset;
    while (narrow.partition.Allocate(25, 0, first_node, first_subset)) continue;
    Walker narrow_walker(narrow);
    narrow_walker.Walk(false);
    if (testing::Test::HasFatalFailure()) return;
    EXPECT_GT(narrow_walker.without_room, 0u);
  }
}

// Leaves without their geometry are as small as the room for nodes over them allows, where subsets
// are split with care.
void CareMakesSmallerLeaves() {
  Random random(8);
  constexpr size_t kTriangles = 50000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.02f);
  size_t leaves[2], bytes[2];
  for (const Rays rays : {Rays::kFew, Rays::kExpected}) {
    Kept kept({mesh}, 8 * kTriangles);
    ASSERT_GT(kept.partition.leaf_lanes(), kLeafLanes);
    kept.rays = rays;
    Walker walker(kept);
    walker.Walk(true);
    leaves[rays == Rays::kExpected] = walker.leaves;
    bytes[rays == Rays::kExpected] = kept.partition.BytesUsed();
  }
  EXPECT_GT(leaves[1], leaves[0] + leaves[0] / 8);
  EXPECT_GT(bytes[1], 7 * kTriangles);
}

// Where leaves take all that they may, a whole partition still has its nodes.
void LeavesLeaveRoomForNodes() {
  Random random(32);
  constexpr size_t kTriangles = 30000;
  const Mesh mesh = unit::MakeSoup(random, kTriangles, 1, 0.03f);
  for (const Rays rays : kAllRays) {
    Kept kept({mesh}, 32 * kTriangles);
    kept.rays = rays;
    uint32_t place;
    size_t leaves = 0;
    while (kept.partition.AllocateLeaf(100, place)) ++leaves;
    EXPECT_GT(100 * leaves, 14 * kTriangles);
    Walker walker(kept);
    walker.Walk(true);
    EXPECT_EQ(walker.rented > 0, rays == Rays::kFew);
  }
}

// Quads and cells fill two lanes, so that a leaf holds fewer of them; triangles beside them one.
void ItemsOfTwoLanes() {
  Random random(34);
  Mesh mesh = unit::MakeSoup(random, 4000, 1, 0.05f);
  std::vector<uint32_t> quads;
  for (uint32_t i = 0; i < 3000; ++i) {
    for (const uint32_t corner : {0u, 1u, 2u, 4u}) quads.push_back(3 * i + corner);
  }
  for (const size_t triangles : {size_t{0}, size_t{1}, size_t{37}, mesh.triangles.size()}) {
    std::vector<Geometry> geometries(2);
    for (Geometry& geometry : geometries) {
      geometry.vertices = {{mesh.vertices.data(), sizeof(Float3)}};
      geometry.vertex_count = mesh.vertices.size();
    }
    geometries[0].shape = Shape::kQuads;
    geometries[0].primitives = {quads.data(), 4 * sizeof(uint32_t)};
    geometries[0].primitive_count = quads.size() / 4;
    geometries[1].geometry_id = 1;
    geometries[1].primitives = {mesh.triangles.data(), 12};
    geometries[1].primitive_count = triangles;
    for (const Rays rays : kAllRays) {
      Kept kept(geometries, kPlenty);
      EXPECT_FALSE(kept.table().all_fill_one_lane());
      kept.rays = rays;
      Walker walker(kept);
      walker.Walk(true);
      EXPECT_GE(walker.leaves, 3000u / 4);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(KeptPartitionTest);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, PartitionsOfEverySize);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TakesFewBytes);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TrianglesThatCoincide);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TrianglesAroundOnePoint);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, DegenerateTriangles);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TeapotInAStadium);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, ScalesOfAllKinds);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, InvalidTrianglesAreLeftOut);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TheNamesOfThoseLeftOutAreKept);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, TheBudgetIsNeverExceeded);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, CareMakesSmallerLeaves);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, LeavesLeaveRoomForNodes);
HWY_EXPORT_AND_TEST_P(KeptPartitionTest, ItemsOfTwoLanes);

}  // namespace dacrt
#endif  // HWY_ONCE
