#include "trace/child_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

namespace dacrt {
namespace {

/// Lets `learnt` see `batches` batches, of which those by an order cost what `costs` says.
std::vector<ChildOrder> Learn(LearntOrder& learnt, const uint64_t* costs, uint32_t batches) {
  std::vector<ChildOrder> orders;
  for (uint32_t i = 0; i < batches; ++i) {
    orders.push_back(learnt.Next());
    learnt.Count(costs[static_cast<std::size_t>(orders.back())]);
  }
  return orders;
}

TEST(ChildOrderTest, TheCheapestOrderIsTaken) {
  constexpr ChildOrder kOrders[] = {ChildOrder::kAsStored, ChildOrder::kNearestFirst,
                                    ChildOrder::kFarthestFirst};
  for (const ChildOrder cheapest : kOrders) {
    uint64_t costs[] = {7, 7, 7};
    costs[static_cast<std::size_t>(cheapest)] = 5;
    constexpr uint32_t kTrials = 4, kPeriod = 50;
    constexpr std::ptrdiff_t kTrial = std::ssize(kOrders) * kTrials;
    LearntOrder learnt(kTrials, kPeriod);
    const auto orders = Learn(learnt, costs, 200);
    // At first as stored; from one trial to the next it is twice as long, up to the period.
    auto begin = orders.begin() + kTrial;
    EXPECT_EQ(std::count(orders.begin(), begin, ChildOrder::kAsStored), kTrial);
    for (const std::ptrdiff_t period :
         {std::min<std::ptrdiff_t>(4 * kTrial, kPeriod), std::ptrdiff_t{kPeriod}}) {
      const auto decided = begin + kTrial, end = begin + period;
      for (const ChildOrder order : kOrders) EXPECT_EQ(std::count(begin, decided, order), kTrials);
      EXPECT_EQ(std::count(decided, end, cheapest), end - decided);
      begin = end;
    }
    EXPECT_EQ(learnt.best(), cheapest);
  }
}

TEST(ChildOrderTest, OfEqualOnesTheSimplest) {
  const uint64_t costs[] = {7, 7, 7};
  LearntOrder learnt(2, 10);
  Learn(learnt, costs, 10);
  EXPECT_EQ(learnt.best(), ChildOrder::kAsStored);
}

// Rays change, and with them what is best for them.
TEST(ChildOrderTest, WhatWasLearntIsForgotten) {
  LearntOrder learnt(2, 20);
  const uint64_t before[] = {9, 3, 9}, now[] = {9, 9, 3};
  Learn(learnt, before, 20 * 5);
  EXPECT_EQ(learnt.best(), ChildOrder::kNearestFirst);
  Learn(learnt, now, 20 * 5);
  EXPECT_EQ(learnt.best(), ChildOrder::kFarthestFirst);
}

// While nodes are made, batches cost something else than those that follow.
TEST(ChildOrderTest, TheFirstBatchesSayNothing) {
  LearntOrder learnt(2, 2048);
  const uint64_t at_first[] = {30, 10, 40}, then[] = {8, 9, 9};
  Learn(learnt, at_first, 6);
  EXPECT_EQ(learnt.best(), ChildOrder::kAsStored);
  for (int trial = 0; trial < 2; ++trial) {
    Learn(learnt, then, 6);
    EXPECT_EQ(learnt.best(), ChildOrder::kAsStored);
  }
}

// Large batches need fewer trials, and are compared by what each part of them cost.
TEST(ChildOrderTest, BatchesCountAsTheyAreLarge) {
  constexpr uint32_t kTrials = 8;
  LearntOrder learnt(kTrials, 2048);
  const uint32_t sizes[] = {20, 30, 40};
  learnt.Count(1, std::size(sizes) * kTrials);
  const uint64_t costs[] = {8, 6, 7};
  for (std::size_t i = 0; i < std::size(sizes); ++i) {
    EXPECT_EQ(learnt.Next(), static_cast<ChildOrder>(i));
    EXPECT_EQ(learnt.best(), ChildOrder::kAsStored);
    learnt.Count(costs[i] * sizes[i], sizes[i]);
  }
  EXPECT_EQ(learnt.best(), ChildOrder::kNearestFirst);
  EXPECT_EQ(learnt.Next(), ChildOrder::kNearestFirst);
}

}  // namespace
}  // namespace dacrt
