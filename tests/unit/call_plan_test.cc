#include "engine/call_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "unit_test.h"

namespace dacrt {
namespace {

constexpr std::size_t kRayCounts[] = {1,     2,     63,    64,      1000,    1024,    1025,
                                      10000, 65536, 65537, 1000000, 5000000, 1u << 30};

Settings WithPieces(uint32_t piece_rays) {
  Settings settings;
  settings.piece_rays = piece_rays;
  return settings;
}

/// Fails if a piece is empty, or larger than the plan says, or than the one before it.
std::size_t CountPieces(const CallPlan& plan, std::size_t rays) {
  std::size_t pieces = 0, last = plan.piece_rays;
  for (std::size_t left = rays; left > 0; ++pieces) {
    const std::size_t next = plan.NextPiece(left);
    EXPECT_GE(next, 1u);
    EXPECT_LE(next, std::min(last, left));
    if (next == 0 || next > left) break;
    last = next;
    left -= next;
  }
  return pieces;
}

/// What the thread does that ends last, of an equal share, where all are as fast.
double SlowestShare(const CallPlan& plan, std::size_t rays) {
  std::vector<std::size_t> done(plan.workers);
  for (std::size_t left = rays; left > 0;) {
    const std::size_t next = plan.NextPiece(left);
    *std::min_element(done.begin(), done.end()) += next;
    left -= next;
  }
  return static_cast<double>(*std::max_element(done.begin(), done.end()) * plan.workers) /
         static_cast<double>(rays);
}

// Pieces hold all rays, none is empty, and none is larger than the settings say.
TEST(CallPlanTest, PiecesHoldAllRays) {
  for (const std::size_t rays : kRayCounts) {
    for (const std::size_t threads : {1u, 2u, 3u, 8u, 1024u}) {
      for (const bool keeps : {false, true}) {
        for (const uint32_t most : {64u, 1000u, 4u << 20, 1u << 30}) {
          const CallPlan plan(rays, threads, keeps, WithPieces(most));
          ASSERT_GE(plan.piece_rays, 1u);
          ASSERT_LE(plan.piece_rays, most);
          ASSERT_LE(plan.piece_rays, rays);
          // No workspace without work.
          ASSERT_GE(plan.workers, 1u);
          ASSERT_LE(plan.workers, threads);
          ASSERT_LE(plan.workers, CountPieces(plan, rays));
        }
      }
    }
  }
}

// The number of pieces was divided by their size, which is 0.
TEST(CallPlanTest, ACallWithoutRaysHasAPlan) {
  for (const bool keeps : {false, true}) {
    const CallPlan plan(0, 8, keeps, WithPieces(1u << 20));
    EXPECT_EQ(plan.workers, 1u);
    EXPECT_EQ(plan.piece_rays, 0u);
  }
}

// Where nothing is kept each piece partitions anew: as few as can be, on the caller's thread.
TEST(CallPlanTest, WithoutAKeptPartitionPiecesAreAsLargeAsTheSettingsSay) {
  for (const std::size_t rays : kRayCounts) {
    CallPlan plan(rays, 8, false, WithPieces(1u << 20));
    EXPECT_EQ(plan.workers, 1u);
    EXPECT_EQ(plan.piece_rays, std::min<std::size_t>(rays, 1u << 20));
    EXPECT_FALSE(plan.Shrink());
  }
}

// Enough pieces for all threads, but no tiny ones.
TEST(CallPlanTest, ThreadsShareTheRays) {
  const CallPlan many(1000000, 8, true, Settings());
  EXPECT_EQ(many.workers, 8u);
  EXPECT_GE(CountPieces(many, 1000000), 16u);
  EXPECT_EQ(many.NextPiece(1000000), many.piece_rays);
  EXPECT_GE(many.NextPiece(5000), 1024u);
  EXPECT_LE(SlowestShare(many, 1000000), 1.05);
  EXPECT_LE(SlowestShare(CallPlan(4096, 2, true, Settings()), 4096), 1.05);
  const CallPlan few(32, 8, true, Settings());
  EXPECT_EQ(few.workers, 1u);
  EXPECT_EQ(few.piece_rays, 32u);
  const CallPlan some(96, 8, true, Settings());
  EXPECT_EQ(some.workers, 3u);
  // What a thread works on stays in a cache, however many rays there are.
  EXPECT_LE(CallPlan(1u << 30, 1, true, Settings()).piece_rays, 65536u);
  EXPECT_EQ(CallPlan(1u << 30, 1, true, Settings()).workers, 1u);
}

// Rays that run close together: many pieces of one size for each thread, none of them tiny.
TEST(CallPlanTest, EvenPiecesAreOfOneSize) {
  for (const std::size_t rays : {4096u, 65536u, 1000000u, 1u << 30}) {
    for (const std::size_t threads : {2u, 3u, 16u}) {
      CallPlan plan(rays, threads, true, Settings());
      const std::size_t before = plan.piece_rays;
      plan.MakeEven(512);
      EXPECT_LE(plan.piece_rays, before);
      EXPECT_LE(plan.piece_rays, 8192u);
      EXPECT_GE(plan.piece_rays, std::min<std::size_t>(before, 512));
      EXPECT_EQ(plan.NextPiece(rays), plan.piece_rays);
      EXPECT_EQ(plan.NextPiece(7), 7u);
      if (plan.piece_rays < before) {
        EXPECT_EQ(plan.NextPiece(plan.piece_rays), plan.piece_rays);
      }
      EXPECT_GE(CountPieces(plan, rays), rays < 65536 ? 4u : 8 * threads);
    }
  }
  // The pieces of a call that the settings cut small stay small.
  CallPlan small(1000000, 2, true, WithPieces(64));
  small.MakeEven(512);
  EXPECT_EQ(small.piece_rays, 64u);
}

// Each next plan takes less, and there is a last one: a small piece on one thread.
TEST(CallPlanTest, ShrinkingTakesLessEachTimeAndEnds) {
  for (const std::size_t rays : kRayCounts) {
    for (const std::size_t threads : {1u, 2u, 1024u}) {
      const Settings settings;
      CallPlan plan(rays, threads, true, settings);
      const auto bytes = [&] {
        return plan.workers *
               WorkspaceShape::ForKept(plan.piece_rays, {.has_instances = true}).Bytes();
      };
      std::size_t before = bytes();
      int steps = 0;
      while (plan.Shrink()) {
        ASSERT_LT(bytes(), before);
        before = bytes();
        ASSERT_GE(plan.piece_rays, 1u);
        ASSERT_LT(++steps, 20);
      }
      EXPECT_EQ(plan.workers, 1u);
      EXPECT_LE(plan.piece_rays, 1024u);
      EXPECT_GE(plan.piece_rays,
                std::min<std::size_t>(1024, CallPlan(rays, threads, true, settings).piece_rays));
      EXPECT_FALSE(plan.Shrink());
      EXPECT_GE(CountPieces(plan, rays) * plan.piece_rays, rays);
    }
  }
}

}  // namespace
}  // namespace dacrt
