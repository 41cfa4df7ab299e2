#include "trace/learnt.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace dacrt {
namespace {

/// Makes an order other than the first one the best.
void Learn(LearntOrder& learnt) {
  const uint64_t costs[] = {9, 9, 3};
  for (int i = 0; i < 10; ++i) learnt.Count(costs[static_cast<uint8_t>(learnt.Next())], 1 << 16);
}

TEST(LearntTest, EachThreadLearnsOfEachScene) {
  alignas(1024) static char scenes[1024];
  Learn(LearntAbout(&scenes[0]).order_of_rays);
  EXPECT_EQ(LearntAbout(&scenes[0]).order_of_rays.best(), ChildOrder::kFarthestFirst);
  EXPECT_EQ(LearntAbout(&scenes[0]).order_of_groups.best(), ChildOrder::kAsStored);
  EXPECT_EQ(LearntAbout(&scenes[512]).order_of_rays.best(), ChildOrder::kAsStored);
  EXPECT_EQ(LearntAbout(&scenes[0]).order_of_rays.best(), ChildOrder::kFarthestFirst);
  std::thread([&] {
    EXPECT_EQ(LearntAbout(&scenes[0]).order_of_rays.best(), ChildOrder::kAsStored);
  }).join();
}

// As in programs that make threads for each frame.
TEST(LearntTest, AThreadBeginsWithWhatOneThatEndedKnew) {
  alignas(1024) static char scenes[1024];
  std::thread([&] { Learn(LearntAbout(&scenes[0]).order_of_rays); }).join();
  std::thread([&] {
    EXPECT_EQ(LearntAbout(&scenes[0]).order_of_rays.best(), ChildOrder::kFarthestFirst);
    EXPECT_EQ(LearntAbout(&scenes[256]).order_of_rays.best(), ChildOrder::kAsStored);
    Learn(LearntAbout(&scenes[256]).order_of_groups);
  }).join();
  std::thread([&] {
    EXPECT_EQ(LearntAbout(&scenes[0]).order_of_rays.best(), ChildOrder::kFarthestFirst);
    EXPECT_EQ(LearntAbout(&scenes[256]).order_of_groups.best(), ChildOrder::kFarthestFirst);
  }).join();
}

}  // namespace
}  // namespace dacrt
