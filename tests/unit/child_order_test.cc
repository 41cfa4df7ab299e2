#include "trace/child_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
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
    constexpr std::ptrdiff_t kTrial = LearntOrder::kOrders * kTrials;
    LearntOrder learnt(kTrials, kPeriod);
    const auto orders = Learn(learnt, costs, 200);
    // From one trial to the next it is twice as long, up to the period.
    auto begin = orders.begin();
    for (const std::ptrdiff_t period :
         {2 * kTrial, std::min<std::ptrdiff_t>(4 * kTrial, kPeriod), std::ptrdiff_t{kPeriod}}) {
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
TEST(ChildOrderTest, TheFirstTrialIsSoonForgotten) {
  LearntOrder learnt(2, 2048);
  const uint64_t at_first[] = {30, 10, 40}, then[] = {8, 9, 9};
  Learn(learnt, at_first, 6);
  EXPECT_EQ(learnt.best(), ChildOrder::kNearestFirst);
  Learn(learnt, then, 200);
  EXPECT_EQ(learnt.best(), ChildOrder::kAsStored);
}

}  // namespace
}  // namespace dacrt
