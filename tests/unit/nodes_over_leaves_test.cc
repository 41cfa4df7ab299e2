#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nodes_over_leaves_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "partition/nodes_over_leaves-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

// The children of a node stand in the order that SortChildren says: of leaves, the largest first.
void LargeLeavesStandFirst() {
  unit::Random random(1);
  const auto scratch = std::make_unique<SubsetScratch>();
  for (int round = 0; round < 20; ++round) {
    std::vector<float> sizes = {1, 2, 3, 4, 5, 6, 7, 8};
    for (size_t i = sizes.size(); i > 1; --i) {
      std::swap(sizes[i - 1], sizes[random.Below(static_cast<uint32_t>(i))]);
    }
    std::vector<TriangleRef> leaves;
    for (size_t i = 0; i < sizes.size(); ++i) {
      const float x = 10.0f * static_cast<float>(i);
      TriangleRef leaf{};
      for (int axis = 0; axis < 3; ++axis) {
        leaf.lower[axis] = axis == 0 ? x : 0;
        leaf.upper[axis] = leaf.lower[axis] + sizes[i];
      }
      leaf.primitive = ChildWord::Block(static_cast<uint32_t>(sizes[i])).bits();
      leaves.push_back(leaf);
    }
    ASSERT_EQ(MakeNodesOver(leaves, *scratch), 1u);
    const WideNode& node = scratch->nodes[0];
    ASSERT_EQ(node.count, sizes.size());
    for (size_t i = 0; i < sizes.size(); ++i) {
      EXPECT_EQ(node.Child(i).block(), sizes.size() - i);
    }
  }
}

/// Each reference as a leaf of its own.
struct SingleLeaves {
  bool IsLeaf(const WeighedRange& range) const { return range.range.count() == 1; }
  ChildWord Child(const BinaryRange& range) { return ChildWord::Block(range.begin); }
};

/// Half the surface of the volumes of all nodes but the root.
double SurfaceOfNodes(std::span<const ExactNode> nodes) {
  double surface = 0;
  for (const ExactNode& node : nodes) {
    const ChildPlanes planes(node, PlaneOffsets(0));
    HWY_ALIGN float near[3][WideNode::kWidth], far[3][WideNode::kWidth];
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t part = 0; part < kParts; ++part) {
        hn::Store(planes.near[part][axis], kEightTag, near[axis] + part * kPartLanes);
        hn::Store(planes.far[part][axis], kEightTag, far[axis] + part * kPartLanes);
      }
    }
    for (size_t k = 0; k < node.count; ++k) {
      if (!node.Child(k).IsInner()) continue;
      const double x = far[0][k] - near[0][k], y = far[1][k] - near[1][k],
                   z = far[2][k] - near[2][k];
      surface += x * y + y * z + z * x;
    }
  }
  return surface;
}

// What is split from the top down has more surface than after ranges have found better places.
void EffortPays() {
  unit::Random random(2);
  const auto scratch = std::make_unique<SubsetScratch>();
  const auto surface_by = [&](const std::vector<TriangleRef>& leaves,
                              const ReinsertionEffort& effort) {
    std::copy(leaves.begin(), leaves.end(), scratch->refs);
    SingleLeaves single;
    const TriangleRange all = MeasureTriangles(scratch->refs, 0, leaves.size());
    const size_t count =
        NodeBuilder(Triangles(), effort, scratch->refs, single, std::span(scratch->ranges),
                    std::span(scratch->nodes), *scratch)
            .Build({all, leaves.size()});
    EXPECT_GT(count, 0u);
    return SurfaceOfNodes(std::span(scratch->nodes).first(count));
  };
  for (int round = 0; round < 5; ++round) {
    std::vector<TriangleRef> leaves(1000);
    for (TriangleRef& leaf : leaves) {
      const unit::Float3 at = random.InCube(0, 10), size = random.InCube(0, 1);
      for (int axis = 0; axis < 3; ++axis) {
        leaf.lower[axis] = at[axis];
        leaf.upper[axis] = at[axis] + size[axis];
      }
    }
    EXPECT_LT(surface_by(leaves, {2, 0}), .98 * surface_by(leaves, {}));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(NodesOverLeavesTest);
HWY_EXPORT_AND_TEST_P(NodesOverLeavesTest, LargeLeavesStandFirst);
HWY_EXPORT_AND_TEST_P(NodesOverLeavesTest, EffortPays);

}  // namespace dacrt
#endif  // HWY_ONCE
