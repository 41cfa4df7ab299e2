#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "open_children_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "trace/trace_one-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::Random;

/// A node whose children can be told apart.
WideNode NodeOfEight() {
  WideNode node{};
  node.count = WideNode::kWidth;
  for (size_t i = 0; i < WideNode::kWidth; ++i) {
    node.SetChild(i, ChildWord::Block(static_cast<uint32_t>(100 + i)));
  }
  return node;
}

/// What stands on a stack above the first `bottom`, from the top on; numbers of children.
std::vector<size_t> FromTheTop(const OpenChildren& open, size_t bottom) {
  std::vector<size_t> children;
  for (size_t i = open.count; i-- > bottom;) {
    children.push_back(ChildWord(open.word[i]).block() - 100);
  }
  return children;
}

// Whatever the children that are entered, and however many stand there already.
void AllArePushedFromTheNearestOn() {
  Random random(1);
  const WideNode node = NodeOfEight();
  for (uint32_t entered = 0; entered <= UINT8_MAX; ++entered) {
    for (int round = 0; round < 20; ++round) {
      HWY_ALIGN float distances[WideNode::kWidth];
      for (float& distance : distances) {
        // Some of them equal, and some at the origin.
        distance =
            random.Below(3) == 0 ? static_cast<float>(random.Below(3)) : random.Uniform(0, 9);
      }
      OpenChildren open;
      const size_t bottom = random.Below(OpenChildren::kMost - WideNode::kWidth + 1);
      for (size_t i = 0; i < bottom; ++i) OpenStack<>(open).Push(50, ChildWord::Block(7));
      OpenStack<>(open).PushAll(node, entered, distances);
      ASSERT_EQ(open.count, bottom + static_cast<size_t>(std::popcount(entered)));
      for (size_t i = 0; i < bottom; ++i) {
        ASSERT_EQ(ChildWord(open.word[i]).block(), 7u);
        ASSERT_EQ(open.distance[i], 50);
      }
      uint32_t seen = 0;
      float last = 0;
      const std::vector<size_t> children = FromTheTop(open, bottom);
      for (size_t i = 0; i < children.size(); ++i) {
        const float stored = open.distance[open.count - 1 - i], distance = distances[children[i]];
        ASSERT_LE(last, stored) << "not in order";
        if (i > 0 && distance == distances[children[i - 1]]) {
          ASSERT_LT(children[i], children[i - 1]) << "of equally near ones the last comes first";
        }
        // It may lie a little before the child, and must not lie behind.
        ASSERT_LE(stored, distance);
        ASSERT_GE(stored, distance * (1 - 0x1p-20f));
        last = stored;
        seen |= 1u << children[i];
      }
      ASSERT_EQ(seen, entered);
    }
  }
}

/// The child that a ray takes; the distances must be aligned as vectors are.
template <Query kQuery>
size_t Take(uint32_t entered, const float* distances, OpenChildren& open) {
  const WideNode node = NodeOfEight();
  OpenStack<> stack(open);
  return stack.Take<kQuery>(PartitionView{}, node, entered, distances).block() - 100;
}

// The nearest is taken, and of equally near ones, as those in which a ray begins, the last.
void TheNearestIsTaken() {
  Random random(2);
  for (uint32_t entered = 1; entered <= UINT8_MAX; ++entered) {
    for (int round = 0; round < 20; ++round) {
      HWY_ALIGN float distances[WideNode::kWidth];
      for (float& distance : distances) distance = static_cast<float>(random.Below(4));
      size_t nearest = WideNode::kWidth;
      for (size_t i = 0; i < WideNode::kWidth; ++i) {
        if (!(entered >> i & 1)) continue;
        if (nearest == WideNode::kWidth || distances[i] <= distances[nearest]) nearest = i;
      }
      OpenChildren open;
      ASSERT_EQ(Take<Query::kClosest>(entered, distances, open), nearest);
      ASSERT_EQ(open.count + 1, static_cast<size_t>(std::popcount(entered)));
    }
  }
}

// Where any hit will do, the children are visited as they are stored.
void TheFirstIsTakenOfAnyHit() {
  for (uint32_t entered = 1; entered <= UINT8_MAX; ++entered) {
    OpenChildren open;
    std::vector<size_t> taken = {Take<Query::kAny>(entered, nullptr, open)};
    for (const size_t child : FromTheTop(open, 0)) taken.push_back(child);
    std::vector<size_t> expected;
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      if (entered >> i & 1) expected.push_back(i);
    }
    ASSERT_EQ(taken, expected);
  }
}

/// Children up to `tfar` that are taken from a stack, which then holds what is left.
template <class Count>
std::vector<size_t> TakeWithin(float tfar, size_t most, OpenChildren& open) {
  OpenStack<Count> stack(open);
  std::vector<size_t> children;
  for (ChildWord next;
       children.size() < most && stack.template Next<Query::kClosest>(tfar, next);) {
    children.push_back(next.block() - 100);
  }
  return children;
}

// What lies behind the end of a ray is passed over.
void TheNextOneIsWithinTheRay() {
  const WideNode node = NodeOfEight();
  HWY_ALIGN const float distances[WideNode::kWidth] = {4, 1, 8, 3, 7, 2, 6, 5};
  OpenChildren open;
  OpenStack<>(open).PushAll(node, 0xFF, distances);
  EXPECT_EQ(TakeWithin<size_t>(4.5f, 1, open), (std::vector<size_t>{1}));
  EXPECT_EQ(open.count, 7u);
  EXPECT_EQ(TakeWithin<size_t&>(4.5f, 2, open), (std::vector<size_t>{5, 3}));
  EXPECT_EQ(open.count, 5u);
  EXPECT_EQ(TakeWithin<size_t>(4.5f, 8, open), (std::vector<size_t>{0}));
  EXPECT_EQ(open.count, 0u);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(OpenChildrenTest);
HWY_EXPORT_AND_TEST_P(OpenChildrenTest, AllArePushedFromTheNearestOn);
HWY_EXPORT_AND_TEST_P(OpenChildrenTest, TheNearestIsTaken);
HWY_EXPORT_AND_TEST_P(OpenChildrenTest, TheFirstIsTakenOfAnyHit);
HWY_EXPORT_AND_TEST_P(OpenChildrenTest, TheNextOneIsWithinTheRay);

}  // namespace dacrt
#endif  // HWY_ONCE
