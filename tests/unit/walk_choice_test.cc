#include "trace/walk_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace dacrt {
namespace {

/// What a ray costs, in ticks.
struct Costs {
  uint64_t by_groups, by_lists;
};

/// Rays of a sample of groups of the smallest size.
constexpr std::size_t kSample = 128;

/// Lets `choice` see `rays` rays that cost so much. Returns how many of them went by lists.
std::size_t See(WalkChoice& choice, std::size_t rays, const Costs& costs,
                bool cannot_be_smaller = true) {
  std::size_t by_lists = 0;
  for (std::size_t done = 0; done < rays;) {
    const std::size_t next = choice.rays_by_lists();
    if (next == 0) {
      choice.CountGroups(kSample, kSample * costs.by_groups, cannot_be_smaller);
      done += kSample;
      continue;
    }
    choice.CountLists(next, next * costs.by_lists);
    by_lists += next;
    done += next;
  }
  return by_lists;
}

constexpr std::size_t kRays = 1 << 20;

TEST(WalkChoiceTest, NearlyAllGoTheQuickerWay) {
  WalkChoice lists, groups;
  EXPECT_GT(See(lists, kRays, {110, 100}), kRays * 9 / 10);
  EXPECT_LT(See(groups, kRays, {100, 140}), kRays / 40);
}

TEST(WalkChoiceTest, GroupsComeFirst) {
  WalkChoice choice;
  EXPECT_EQ(choice.rays_by_lists(), 0U);
  EXPECT_EQ(See(choice, policy::kSamplesOfGroups * kSample, {100, 1}), 0U);
  EXPECT_EQ(choice.rays_by_lists(), policy::kFewestByLists);
}

// Some rays at a time, and twice as many the next time.
TEST(WalkChoiceTest, RunsOfListsGrowUpToALimit) {
  WalkChoice choice;
  for (std::size_t run = policy::kFewestByLists; run <= 4 * policy::kMostByLists; run *= 2) {
    while (choice.rays_by_lists() == 0) choice.CountGroups(kSample, 200, true);
    EXPECT_EQ(choice.rays_by_lists(), std::min(run, policy::kMostByLists));
    choice.CountLists(choice.rays_by_lists(), 100);
  }
}

// A call may end before: the next one goes on, unless what is left is not worth it.
TEST(WalkChoiceTest, ARunGoesOnInTheNextCall) {
  WalkChoice choice;
  See(choice, kRays, {110, 100});
  while (choice.rays_by_lists() == 0) choice.CountGroups(kSample, 110 * kSample, true);
  ASSERT_EQ(choice.rays_by_lists(), policy::kMostByLists);
  choice.CountLists(policy::kMostByLists - policy::kFewestByLists, 100);
  EXPECT_EQ(choice.rays_by_lists(), policy::kFewestByLists);
  choice.CountLists(1, 1);
  EXPECT_EQ(choice.rays_by_lists(), 0U);
}

TEST(WalkChoiceTest, WhereGroupsCanBeSmallerTheyAreFirst) {
  WalkChoice choice;
  EXPECT_EQ(See(choice, kRays, {200, 100}, false), 0U);
}

// While nodes are made, rays cost something else than those that follow.
TEST(WalkChoiceTest, WhatWasDearIsTriedAgain) {
  WalkChoice choice;
  See(choice, kRays / 4, {100, 300});
  EXPECT_GT(See(choice, kRays, {100, 80}), kRays / 2);
}

TEST(WalkChoiceTest, AThreadThatIsInterruptedSaysLittle) {
  WalkChoice choice;
  See(choice, kRays / 4, {100, 140});
  choice.CountGroups(kSample, 1000 * 100 * kSample, true);
  EXPECT_LT(See(choice, kRays, {100, 140}), kRays / 40);
}

}  // namespace
}  // namespace dacrt
