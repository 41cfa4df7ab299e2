#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
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

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(NodesOverLeavesTest);
HWY_EXPORT_AND_TEST_P(NodesOverLeavesTest, LargeLeavesStandFirst);

}  // namespace dacrt
#endif  // HWY_ONCE
