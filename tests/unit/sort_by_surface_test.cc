#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sort_by_surface_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "partition/split_subset-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Mesh;
using unit::Random;

/// What the leaves into which a mesh is cut cost: half of their surface, in parts of that of all,
/// and a part for each of them (see CutRow).
double CostOfLeaves(const Mesh& mesh, SplitRule rule) {
  const TriangleMesh view = mesh.View();
  const GeometryTable table({&view, 1});
  const auto scratch = std::make_unique<SubsetScratch>();
  std::vector<uint32_t> order(view.triangle_count);
  std::iota(order.begin(), order.end(), 0u);
  EXPECT_GT(SplitTriangles(table, kLeafLanes, 0, order, rule, *scratch), 0u);
  double surface = 0, leaves = 0;
  Extent leaf = Extent::Empty(), all = Extent::Empty();
  for (const uint32_t entry : order) {
    TriangleRef ref;
    EXPECT_TRUE(BoundTriangle(table, table.Locate(KeptOrder::NumberOf(entry)), ref));
    leaf.Join(Extent::Of(ref));
    if (!(entry & KeptOrder::kLastOfLeaf)) continue;
    surface += leaf.HalfArea();
    ++leaves;
    all.Join(leaf);
    leaf = Extent::Empty();
  }
  return surface / all.HalfArea() + leaves * WideNode::kWidth / static_cast<double>(order.size());
}

/// A rough ball of so many rings.
Mesh MakeBall(Random& random, uint32_t rings) {
  Mesh ball;
  const uint32_t row = 2 * rings;
  for (uint32_t i = 0; i <= rings; ++i) {
    for (uint32_t k = 0; k < row; ++k) {
      const float up = 3.14159265f * static_cast<float>(i) / static_cast<float>(rings),
                  around = 3.14159265f * static_cast<float>(k) / static_cast<float>(rings),
                  radius = random.Uniform(0.97f, 1.03f);
      ball.vertices.push_back({radius * std::sin(up) * std::cos(around), radius * std::cos(up),
                               radius * std::sin(up) * std::sin(around)});
    }
  }
  for (uint32_t i = 0; i < rings; ++i) {
    for (uint32_t k = 0; k < row; ++k) {
      const uint32_t a = i * row + k, b = i * row + (k + 1) % row;
      ball.triangles.push_back({a, b, a + row});
      ball.triangles.push_back({b, b + row, a + row});
    }
  }
  return ball;
}

void LeavesCostLess() {
  Random random(91);
  for (const uint32_t rings : {10u, 16u, 22u}) {
    const Mesh ball = MakeBall(random, rings);
    EXPECT_LT(CostOfLeaves(ball, SplitRule::kCare), 0.97 * CostOfLeaves(ball, SplitRule::kBuy))
        << ball.triangles.size() << " triangles";
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(SortBySurfaceTest);
HWY_EXPORT_AND_TEST_P(SortBySurfaceTest, LeavesCostLess);

}  // namespace dacrt
#endif  // HWY_ONCE
