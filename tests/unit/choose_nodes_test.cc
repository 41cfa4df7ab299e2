#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "binary_partition.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "choose_nodes_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "partition/choose_nodes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BinaryPartition;
using unit::MakePartition;
using unit::Random;

/// The least surface of the nodes over a range that takes at most `places` of a node above it, by
/// trying everything.
double LeastSurface(const BinaryPartition& ranges, uint32_t range, uint32_t places) {
  const BinaryRange& own = ranges[range];
  if (own.IsLeaf()) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (uint32_t left = 1; left < places; ++left) {
    least = std::min(least, LeastSurface(ranges, own.first, left) +
                                LeastSurface(ranges, own.first + 1, places - left));
  }
  if (places == WideNode::kWidth) return least;
  return std::min(least, own.bounds.HalfArea() +
                             LeastSurface(ranges, range, static_cast<uint32_t>(WideNode::kWidth)));
}

/// What the nodes of a partition are.
struct Nodes {
  double surface = 0;
  size_t count = 0;
  std::vector<uint32_t> leaves;  ///< their references, in the order in which they are found

  Nodes(const BinaryPartition& ranges, uint32_t root) { Visit(ranges, root); }

  void Visit(const BinaryPartition& ranges, uint32_t node) {
    ++count;
    surface += ranges[node].bounds.HalfArea();
    uint32_t children[WideNode::kWidth];
    const size_t child_count = ChildrenOf(ranges.data(), node, children);
    ASSERT_LE(child_count, WideNode::kWidth);
    for (size_t i = 0; i < child_count; ++i) {
      if (ranges[children[i]].IsLeaf()) {
        leaves.push_back(ranges[children[i]].begin);
      } else {
        Visit(ranges, children[i]);
      }
    }
  }
};

void ExpectOrder(const std::vector<uint32_t>& leaves, uint32_t count) {
  ASSERT_EQ(leaves.size(), count);
  for (uint32_t i = 0; i < count; ++i) EXPECT_EQ(leaves[i], i);
}

void TheSurfaceIsTheLeast() {
  Random random(71);
  for (uint32_t leaves = 2; leaves <= 14; ++leaves) {
    for (int round = 0; round < 5; ++round) {
      BinaryPartition ranges = MakePartition(random, leaves, false);
      ChooseNodes(ranges.data());
      const Nodes nodes(ranges, 0);
      ExpectOrder(nodes.leaves, leaves);
      const double own = ranges[0].bounds.HalfArea();
      const double least = own + LeastSurface(ranges, 0, WideNode::kWidth);
      // A node more costs as much as a little surface.
      EXPECT_LE(nodes.surface, least + own * 0x1p-16 * leaves) << leaves << " leaves";
    }
  }
}

/// Where no box has a surface, nodes are full.
void NodesWithoutSurfaceAreFull() {
  Random random(72);
  for (const uint32_t leaves : {1u, 8u, 9u, 64u, 500u}) {
    BinaryPartition ranges = MakePartition(random, leaves, true);
    ChooseNodes(ranges.data());
    const Nodes nodes(ranges, 0);
    ExpectOrder(nodes.leaves, leaves);
    // Each node but the root takes one place and gives up to eight.
    EXPECT_GE(nodes.count, (leaves + 5) / 7);
    EXPECT_LE(nodes.count, std::max(1u, leaves / 4));
  }
}

/// The surface of the leaves of a range together.
double LeafSurface(const BinaryPartition& ranges, uint32_t range) {
  const BinaryRange& own = ranges[range];
  if (own.IsLeaf()) return own.bounds.HalfArea();
  return LeafSurface(ranges, own.first) + LeafSurface(ranges, own.first + 1);
}

/// The children of a node, sorted.
std::vector<uint32_t> SortedChildren(const BinaryPartition& ranges, uint32_t node) {
  uint32_t children[WideNode::kWidth];
  const size_t count = ChildrenOf(ranges.data(), node, children);
  std::vector<uint32_t> sorted(children, children + count), as_found = sorted;
  SortChildren(ranges.data(), sorted.data(), count);
  EXPECT_TRUE(std::is_permutation(sorted.begin(), sorted.end(), as_found.begin()));
  return sorted;
}

/// Large ones that hold little come first, wherever the scene lies and however large it is.
void LargeChildrenThatHoldLittleComeFirst() {
  Random random(74);
  for (const float scale : {1.0f, 1e-12f, 1e12f}) {
    for (uint32_t leaves = 2; leaves <= 60; ++leaves) {
      BinaryPartition ranges = MakePartition(random, leaves, false, scale);
      ChooseNodes(ranges.data());
      for (uint32_t node = 0; node < ranges.size(); ++node) {
        if (ranges[node].IsLeaf()) continue;
        double last = 0;
        for (const uint32_t child : SortedChildren(ranges, node)) {
          const double surface = ranges[child].bounds.HalfArea() / ranges[0].bounds.HalfArea();
          const double held = LeafSurface(ranges, child) / ranges[0].bounds.HalfArea();
          const double key = held / (surface * surface);
          EXPECT_GE(key, last * (1 - 1e-4)) << leaves << " leaves";
          last = key;
        }
      }
    }
  }
}

/// Where surfaces, or sums of them, are infinite, there is no best choice, and still one.
void NodesOfInfiniteSurfaceHoldAll() {
  Random random(73);
  for (const uint32_t leaves : {2u, 8u, 9u, 64u, 500u}) {
    for (const float scale : {8e18f, 1e19f, 1e20f, 1e30f}) {
      BinaryPartition ranges = MakePartition(random, leaves, false, scale);
      ChooseNodes(ranges.data());
      ExpectOrder(Nodes(ranges, 0).leaves, leaves);
      for (uint32_t node = 0; node < ranges.size(); ++node) {
        if (!ranges[node].IsLeaf()) SortedChildren(ranges, node);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(ChooseNodesTest);
HWY_EXPORT_AND_TEST_P(ChooseNodesTest, TheSurfaceIsTheLeast);
HWY_EXPORT_AND_TEST_P(ChooseNodesTest, NodesWithoutSurfaceAreFull);
HWY_EXPORT_AND_TEST_P(ChooseNodesTest, LargeChildrenThatHoldLittleComeFirst);
HWY_EXPORT_AND_TEST_P(ChooseNodesTest, NodesOfInfiniteSurfaceHoldAll);

}  // namespace dacrt
#endif  // HWY_ONCE
