// What stands behind the children of a node, and who fills in its leaves.
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "geometry/wide_node.h"

namespace dacrt {
namespace {

/// Which of its four kinds a word is of, by what it says of itself; nothing if it says two things.
std::string KindsOf(ChildWord word) {
  std::string kinds;
  if (word.IsInner()) kinds += "inner";
  if (word.IsSubset()) kinds += "subset";
  if (word.IsBlock()) kinds += "block";
  if (word.IsRange()) kinds += "range";
  return kinds;
}

// What stands behind a child, and its number, come back as they were written, up to the largest.
TEST(ChildWordTest, KindsAndNumbersComeBack) {
  for (const uint32_t most :
       {ChildWord::kMostNumber, ChildWord::kMostBlock, ChildWord::kMostRange}) {
    for (const uint32_t number : {0u, 1u, 2u, 1000000u, most / 2, most - 1, most}) {
      if (number <= ChildWord::kMostNumber) {
        const ChildWord inner = ChildWord::Inner(number), subset = ChildWord::Subset(number);
        EXPECT_EQ(KindsOf(inner), "inner");
        EXPECT_EQ(inner.number(), number);
        EXPECT_FALSE(inner.IsLeaf());
        EXPECT_EQ(KindsOf(subset), "subset");
        EXPECT_EQ(subset.number(), number);
        EXPECT_FALSE(subset.IsLeaf());
      }
      if (number <= ChildWord::kMostBlock) {
        const ChildWord block = ChildWord::Block(number);
        EXPECT_EQ(KindsOf(block), "block");
        EXPECT_EQ(block.block(), number);
        EXPECT_TRUE(block.IsLeaf());
      }
      const ChildWord range = ChildWord::Range(number);
      EXPECT_EQ(KindsOf(range), "range");
      EXPECT_EQ(range.range(), number);
      EXPECT_TRUE(range.IsLeaf());
      EXPECT_EQ(ChildWord(range.bits()).bits(), range.bits());
    }
  }
  // A number of every triangle that a scene can have.
  static_assert(ChildWord::kMostRange == INT32_MAX);
}

TEST(WideNodeChildTest, WordsComeBack) {
  WideNode node{};
  node.count = WideNode::kWidth;
  for (std::size_t i = 0; i < WideNode::kWidth; ++i) {
    node.SetChild(i, ChildWord::Block(static_cast<uint32_t>(17 * i)));
  }
  for (std::size_t i = 0; i < WideNode::kWidth; ++i) {
    EXPECT_EQ(node.Child(i).bits(), ChildWord::Block(static_cast<uint32_t>(17 * i)).bits());
  }
}

// One thread at a time gets the leaves to fill in, and those who wait see what it did.
TEST(WideNodeLeavesTest, OneThreadFillsThemIn) {
  for (int round = 0; round < 50; ++round) {
    WideNode node{};
    node.count = 2;
    for (uint32_t i = 0; i < 2; ++i) {
      node.SetChild(i, ChildWord::Block(i));
      node.SetLeafStale(i);
    }
    std::atomic<int> inside{0}, filled{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        while (!node.TryLockLeaves()) {
          node.WaitForLeaves();
          if (node.StaleLeaves(3) == 0) return;
        }
        ASSERT_EQ(++inside, 1);
        filled += node.StaleLeaves(3) != 0;
        node.SetLeavesDone(3);
        --inside;
        node.UnlockLeaves();
      });
    }
    for (std::thread& thread : threads) thread.join();
    ASSERT_EQ(filled, 1);
    ASSERT_EQ(node.BareLeaves(255), 0u);
  }
}

TEST(WideNodeLeavesTest, EachLeafIsDoneByItself) {
  WideNode node{};
  node.count = 4;
  node.SetChild(0, ChildWord::Inner(7));
  node.SetChild(1, ChildWord::Block(1));
  node.SetChild(2, ChildWord::Range(2));
  node.SetChild(3, ChildWord::Block(3));
  node.bare = 0b0100;
  node.SetLeafStale(1);
  node.SetLeafStale(3);
  EXPECT_EQ(node.BareLeaves(255), 0b1110u);
  EXPECT_EQ(node.StaleLeaves(255), 0b1010u);
  EXPECT_EQ(node.BareLeaves(0b0011), 0b0010u);
  node.SetLeavesDone(0b0010);
  EXPECT_EQ(node.BareLeaves(255), 0b1100u);
  EXPECT_EQ(node.StaleLeaves(255), 0b1000u);
  node.SetLeavesDone();
  EXPECT_EQ(node.BareLeaves(255), 0u);
}

// A leaf without a copy has been visited or not, which is nothing to one with a wrong copy.
TEST(WideNodeLeavesTest, EachLeafIsVisitedByItself) {
  WideNode node{};
  node.count = 5;
  node.SetChild(0, ChildWord::Inner(7));
  node.SetChild(1, ChildWord::Range(1));
  node.SetChild(2, ChildWord::Range(2));
  node.SetChild(3, ChildWord::Block(3));
  node.SetChild(4, ChildWord::Block(4));
  node.SetLeavesBare();
  EXPECT_EQ(node.UnvisitedLeaves(255), 0u);
  node.SetLeavesUnvisited();
  node.SetLeafStale(3);
  EXPECT_EQ(node.BareLeaves(255), 0b01110u);
  EXPECT_EQ(node.UnvisitedLeaves(255), 0b00110u);
  EXPECT_EQ(node.UnvisitedLeaves(0b00011), 0b00010u);
  EXPECT_EQ(node.StaleLeaves(255), 0b01000u);
  node.SetLeavesVisited(0b00010);
  EXPECT_EQ(node.BareLeaves(255), 0b01110u) << "it may have a copy now";
  EXPECT_EQ(node.UnvisitedLeaves(255), 0b00100u);
  EXPECT_EQ(node.StaleLeaves(255), 0b01000u);
  node.SetLeavesDone(0b00100);
  EXPECT_EQ(node.BareLeaves(255), 0b01010u);
  EXPECT_EQ(node.UnvisitedLeaves(255), 0u);
}

}  // namespace
}  // namespace dacrt
