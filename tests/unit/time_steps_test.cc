// Moments of geometries that move, in and beside their time ranges.
#include "geometry/time_steps.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

namespace dacrt {
namespace {

void ExpectMoment(const TimeSteps& steps, float time, uint32_t step, float fraction) {
  const std::optional<Moment> moment = steps.At(time);
  ASSERT_TRUE(moment) << "at " << time;
  EXPECT_EQ(moment->step, step) << "at " << time;
  EXPECT_EQ(moment->fraction, fraction) << "at " << time;
}

TEST(TimeStepsTest, TheRangeIsDividedEqually) {
  const TimeSteps two(2, {1, 3}), five(5, {1, 3});
  ExpectMoment(two, 1, 0, 0);
  ExpectMoment(two, 1.5f, 0, 0.25f);
  ExpectMoment(five, 1, 0, 0);
  ExpectMoment(five, 1.25f, 0, 0.5f);
  ExpectMoment(five, 1.5f, 1, 0);
  ExpectMoment(five, 2.875f, 3, 0.75f);
}

TEST(TimeStepsTest, TheEndBelongsToTheLastSegment) {
  ExpectMoment(TimeSteps(2, {1, 3}), 3, 0, 1);
  ExpectMoment(TimeSteps(5, {1, 3}), 3, 3, 1);
}

TEST(TimeStepsTest, BesideTheRangeThereIsNothing) {
  for (const uint32_t count : {2u, 5u}) {
    const TimeSteps steps(count, {1, 3});
    for (const float time : {0.0f, 0.99f, 3.01f, std::numeric_limits<float>::quiet_NaN()}) {
      EXPECT_FALSE(steps.At(time)) << "at " << time;
    }
  }
}

TEST(TimeStepsTest, WhatDoesNotMoveIsAlwaysThere) { ExpectMoment(TimeSteps(1, {1, 3}), 7, 0, 0); }

TEST(TimeStepsTest, ARangeOfNoLengthIsAtItsFirstStep) {
  ExpectMoment(TimeSteps(2, {1, 1}), 1, 0, 0);
  ExpectMoment(TimeSteps(5, {1, 1}), 1, 0, 0);
}

}  // namespace
}  // namespace dacrt
