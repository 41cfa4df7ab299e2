#include "trace/learnt_best.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace dacrt {
namespace {

TEST(LearntBestTest, AWayIsTriedForARun) {
  constexpr uint32_t kTrials = 8, kRun = 4, kBatch = 2;
  LearntBest<2> learnt(kTrials, 1000, kRun);
  learnt.Count(0, 2 * kTrials);
  std::vector<uint32_t> ways;
  while (learnt.is_trial()) {
    ways.push_back(learnt.Next());
    learnt.Count(ways.back() == 0 ? 9 : 7, kBatch);
  }
  EXPECT_EQ(ways, (std::vector<uint32_t>{0, 0, 1, 1, 0, 0, 1, 1}));
  EXPECT_EQ(learnt.best(), 1u);
  EXPECT_EQ(learnt.Next(), 1u);
}

// What costs are, nobody has to find out then.
TEST(LearntBestTest, CostsCountInTrialsOnly) {
  LearntBest<2> learnt(1, 8);
  while (!learnt.is_trial()) learnt.Count(1000);
  learnt.Count(5);
  learnt.Count(6);
  ASSERT_FALSE(learnt.is_trial());
  EXPECT_EQ(learnt.best(), 0u);
  while (!learnt.is_trial()) learnt.Count(1000);
  learnt.Count(9);
  learnt.Count(1);
  EXPECT_EQ(learnt.best(), 1u);
}

}  // namespace
}  // namespace dacrt
