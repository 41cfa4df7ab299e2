#include "paper/split_cost.h"

#include <gtest/gtest.h>

namespace dacrt {
namespace {

// The worked example of the slides: of four candidates the second costs least. Which rays and
// triangles give those costs is shown in choose_split_test.cc.
TEST(SplitCostTest, IsThatOfTheSlidesExample) {
  EXPECT_DOUBLE_EQ(SplitCost(1 / 3.0, 1, 3 / 3.0, 5), 16 / 3.0);
  EXPECT_DOUBLE_EQ(SplitCost(1 / 3.0, 2, 3 / 3.0, 4), 14 / 3.0);
  EXPECT_DOUBLE_EQ(SplitCost(2 / 3.0, 3, 3 / 3.0, 3), 15 / 3.0);
  EXPECT_DOUBLE_EQ(SplitCost(3 / 3.0, 4, 2 / 3.0, 2), 16 / 3.0);
}

TEST(SplitCostTest, SidesThatNoRayEntersCostNothing) {
  EXPECT_EQ(SplitCost(0, 1000000, 0, 5), 0);
  EXPECT_EQ(SplitCost(0, 1000000, 1, 5), 5);
}

TEST(SplitCostTest, CountsBeyondSinglePrecisionAreExact) {
  EXPECT_EQ(SplitCost(1, 0xFFFFFFFDu, 1, 2), 4294967295.0);
}

// alpha > 1 - C_bv / (N_child C_child): 0.5 for an inner child, which has two boxes, whatever its
// triangles; the share of its triangle tests for a leaf.
TEST(SkipRatioTest, InnerChildIsHalf) {
  EXPECT_EQ(SkipRatio(false, 9), 0.5);
  EXPECT_EQ(SkipRatio(false, 1000000), 0.5);
}

// The two costs are measured, so that only what follows from them is tested here: with more
// triangles in a leaf filtering pays for a larger share of rays, up to nearly all.
TEST(SkipRatioTest, LeafFollowsItsTriangles) {
  EXPECT_DOUBLE_EQ(SkipRatio(true, 1), 1 - kBoxCost / kTriangleCost);
  for (std::size_t count = 1; count < 64; ++count) {
    EXPECT_LT(SkipRatio(true, count), SkipRatio(true, count + 1));
  }
  EXPECT_LT(SkipRatio(true, 64), 1);
  EXPECT_GT(SkipRatio(true, 64), 0.95);
}

// Filtering a child costs C_bv a ray and then alpha of the child's work; skipping costs all of it.
TEST(SkipRatioTest, IsWhereTheCostsAreEqual) {
  for (std::size_t count = 1; count <= 64; ++count) {
    const double child = static_cast<double>(count) * kTriangleCost;
    EXPECT_DOUBLE_EQ(kBoxCost + SkipRatio(true, count) * child, child);
  }
}

}  // namespace
}  // namespace dacrt
