#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "binary_partition.h"
#include "unit_test.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reinsert_ranges_test.cc"
#include <hwy/foreach_target.h>
#include <hwy/tests/hwy_gtest.h>

#include "partition/reinsert_ranges-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace {

using unit::BinaryPartition;
using unit::CompletePartition;
using unit::MakePartition;
using unit::Random;

constexpr ReinsertionEffort kAll{1000, 0};

void Reinsert(BinaryPartition& ranges, const ReinsertionEffort& effort) {
  Reinserter(ranges, ranges[0].bounds.SurfaceScale()).Run(effort);
}

/// Surfaces of all ranges together, without what is written there.
double SurfaceOfAll(const BinaryPartition& ranges, uint32_t number, Box& bounds) {
  const BinaryRange& range = ranges[number];
  bounds = range.bounds;
  if (range.IsLeaf()) return bounds.HalfArea();
  double sum = 0;
  bounds = Box::Empty();
  for (const uint32_t half : {range.first, range.first + 1}) {
    Box of_half;
    sum += SurfaceOfAll(ranges, half, of_half);
    bounds.Extend(of_half.lower);
    bounds.Extend(of_half.upper);
  }
  return sum + bounds.HalfArea();
}
double SurfaceOfAll(const BinaryPartition& ranges) {
  Box bounds;
  return SurfaceOfAll(ranges, 0, bounds);
}

void VisitAll(const BinaryPartition& ranges, uint32_t number, std::vector<uint32_t>& leaves) {
  const BinaryRange& range = ranges[number];
  if (range.IsLeaf()) return leaves.push_back(range.begin);
  for (const uint32_t half : {range.first, range.first + 1}) {
    EXPECT_EQ(ranges[half].parent, number);
    VisitAll(ranges, half, leaves);
  }
  Box bounds;
  SurfaceOfAll(ranges, number, bounds);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(range.bounds.lower[axis], bounds.lower[axis]);
    EXPECT_EQ(range.bounds.upper[axis], bounds.upper[axis]);
  }
}

/// Of the same leaves, each once.
void ExpectPartition(const BinaryPartition& ranges, size_t leaf_count) {
  std::vector<uint32_t> leaves;
  VisitAll(ranges, 0, leaves);
  std::sort(leaves.begin(), leaves.end());
  ASSERT_EQ(leaves.size(), leaf_count);
  for (size_t i = 0; i < leaves.size(); ++i) EXPECT_EQ(leaves[i], i);
}

bool IsWithin(const BinaryPartition& ranges, uint32_t number, uint32_t outer) {
  while (number != outer && number != 0) number = ranges[number].parent;
  return number == outer;
}

/// What all surfaces are where `moving` is beside `beside`, by hand.
double SurfaceIfMoved(BinaryPartition ranges, uint32_t moving, uint32_t beside) {
  const uint32_t parent = ranges[moving].parent, first = ranges[parent].first;
  const BinaryRange moved = ranges[moving];
  ranges[parent] = ranges[moving == first ? first + 1 : first];
  // Its sibling stands there now.
  const BinaryRange other = ranges[beside];
  ranges[first] = other;
  ranges[first + 1] = moved;
  ranges[beside].first = first;
  return SurfaceOfAll(ranges);
}

void NoOtherPlaceIsBetter() {
  Random random(81);
  for (uint32_t leaves = 3; leaves <= 24; ++leaves) {
    BinaryPartition ranges = MakePartition(random, leaves, false);
    const double before = SurfaceOfAll(ranges);
    Reinsert(ranges, kAll);
    ExpectPartition(ranges, leaves);
    const double after = SurfaceOfAll(ranges), slack = ranges[0].bounds.HalfArea() * 0x1p-16;
    EXPECT_LE(after, before + slack);
    const auto count = static_cast<uint32_t>(ranges.size());
    for (uint32_t moving = 1; moving < count; ++moving) {
      const uint32_t parent = ranges[moving].parent, first = ranges[parent].first;
      const uint32_t sibling = moving == first ? first + 1 : first;
      for (uint32_t beside = 1; beside < count; ++beside) {
        // Beside its sibling it is, and all ranges that hold it change when it is taken out.
        if (beside == sibling || beside == parent || IsWithin(ranges, beside, moving)) continue;
        if (IsWithin(ranges, moving, beside)) continue;
        EXPECT_GE(SurfaceIfMoved(ranges, moving, beside), after - slack)
            << leaves << " leaves, " << moving << " beside " << beside;
      }
    }
  }
}

/// Pairs of far leaves become pairs of near ones.
void WhatIsNearComesTogether() {
  for (int axis = 0; axis < 3; ++axis) {
    BinaryPartition ranges(7);
    ranges[0].first = 1;
    ranges[1].first = 3;
    ranges[2].first = 5;
    for (uint32_t leaf = 0; leaf < 4; ++leaf) {
      BinaryRange& range = ranges[3 + leaf];
      range.begin = leaf;
      range.end = leaf + 1;
      range.bounds = {};
      for (int i = 0; i < 3; ++i) range.bounds.upper[i] = 1;
      // The first and the third, and the second and the fourth, are neighbours.
      const float shift =
          2.0f * static_cast<float>(leaf / 2) + 10.0f * static_cast<float>(leaf % 2);
      range.bounds.lower[axis] += shift;
      range.bounds.upper[axis] += shift;
    }
    CompletePartition(ranges);
    Reinsert(ranges, kAll);
    ExpectPartition(ranges, 4);
    for (const uint32_t half : {ranges[0].first, ranges[0].first + 1}) {
      EXPECT_EQ(ranges[half].bounds.LongestSide(), 3);
    }
  }
}

/// Whatever its surfaces are, a partition stays one.
void AnyPartitionStaysOne() {
  Random random(82);
  for (const uint32_t leaves : {1u, 2u, 9u, 64u, 500u}) {
    for (const float size : {1.0f, 1e-25f, 8e18f, 1e20f, 1e38f}) {
      for (const bool is_flat : {false, true}) {
        BinaryPartition ranges = MakePartition(random, leaves, is_flat, size);
        const double before = SurfaceOfAll(ranges);
        Reinsert(ranges, kAll);
        ExpectPartition(ranges, leaves);
        if (std::isfinite(before)) {
          EXPECT_LE(SurfaceOfAll(ranges), before * (1 + 0x1p-16));
        }
      }
    }
  }
}

/// A long spine with a pair at each step, where all places are as good as each other and all are
/// looked at: more are open than are remembered.
void PartitionsFarFromBalanceEnd() {
  constexpr uint32_t kSteps = 300;
  BinaryPartition ranges(1);
  uint32_t spine = 0, leaf = 0;
  const auto add_halves = [&](uint32_t number) {
    const auto first = static_cast<uint32_t>(ranges.size());
    ranges[number].first = first;
    ranges.resize(first + 2);
    return first;
  };
  const auto set_leaf = [&](uint32_t number) {
    ranges[number].first = 0;
    ranges[number].begin = leaf++;
    ranges[number].bounds = {{0, 0, 0, 0}, {1, 1, 1, 0}};
  };
  for (uint32_t step = 0; step < kSteps; ++step) {
    const uint32_t first = add_halves(spine);
    const uint32_t pair = add_halves(first);
    set_leaf(pair);
    set_leaf(pair + 1);
    spine = first + 1;
  }
  set_leaf(spine);
  ranges[ranges[ranges[0].first].first]
      .bounds = {};  // of no surface: wherever it is it saves nothing
  CompletePartition(ranges);
  Reinsert(ranges, {1, 0});
  ExpectPartition(ranges, leaf);
}

/// Only what may save enough is tried, and as often as is said.
void EffortIsLimited() {
  Random random(83);
  BinaryPartition ranges = MakePartition(random, 500, false);
  const double before = SurfaceOfAll(ranges);
  const auto surface_after = [&](const ReinsertionEffort& effort) {
    BinaryPartition now = ranges;
    Reinsert(now, effort);
    return SurfaceOfAll(now);
  };
  EXPECT_EQ(surface_after({}), before);
  EXPECT_EQ(surface_after({1000, 1e6f}), before);
  const double quick = surface_after({1, 1}), once = surface_after({1, 0});
  const double all = surface_after(kAll);
  EXPECT_LT(quick, before);
  EXPECT_LT(once, quick);
  EXPECT_LT(all, once);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dacrt {

HWY_BEFORE_TEST(ReinsertRangesTest);
HWY_EXPORT_AND_TEST_P(ReinsertRangesTest, NoOtherPlaceIsBetter);
HWY_EXPORT_AND_TEST_P(ReinsertRangesTest, WhatIsNearComesTogether);
HWY_EXPORT_AND_TEST_P(ReinsertRangesTest, AnyPartitionStaysOne);
HWY_EXPORT_AND_TEST_P(ReinsertRangesTest, PartitionsFarFromBalanceEnd);
HWY_EXPORT_AND_TEST_P(ReinsertRangesTest, EffortIsLimited);

}  // namespace dacrt
#endif  // HWY_ONCE
