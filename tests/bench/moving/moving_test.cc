// The parts of the comparison on scenes that change.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "hit_shares.h"
#include "moving_cells.h"
#include "moving_contest.h"
#include "moving_report.h"
#include "room.h"

namespace dacrt::bench {
namespace {

BenchScene RoomForEmbree() {
  BenchScene room = Room();
  room.mesh.positions.push_back(0);  // Embree reads it with the last vertex
  return room;
}

class ChangeTest : public testing::TestWithParam<const char*> {};

TEST_P(ChangeTest, SomethingChangesEachFrame) {
  const BenchScene room = RoomForEmbree();
  const auto moving = FindChangeKind(GetParam())->make(room);
  const auto state = [&] {
    std::vector<float> all;
    for (const GeometryContent& geometry : moving->content().geometries) {
      all.insert(all.end(), geometry.transform.begin(), geometry.transform.end());
      all.push_back(static_cast<float>(geometry.primitive_count));
      constexpr std::uintptr_t kExact = 1 << 24;  // a float holds what is less
      all.push_back(reinterpret_cast<std::uintptr_t>(geometry.primitives) % kExact);
      if (geometry.vertices.empty()) continue;
      all.insert(all.end(), geometry.vertices[0], geometry.vertices[0] + 3 * geometry.vertex_count);
    }
    return all;
  };
  EXPECT_GT(moving->change().count, 0u);
  EXPECT_LE(moving->change().first + moving->change().count, moving->content().geometries.size());
  for (int frame = 0; frame < 5; ++frame) {
    const std::vector<float> before = state();
    moving->Advance();
    EXPECT_NE(state(), before);
  }
}

TEST_P(ChangeTest, ACommitAgainIsAsGoodAsANewScene) {
  const BenchScene hall = SceneSource("hall-75k", "").LoadForEmbree();
  const ChangeKind& change = *FindChangeKind(GetParam());
  for (const char* const path : {DACRT_REAL_EMBREE, DACRT_DROP_IN}) {
    const EmbreeLibrary library(path, "threads=1");
    for (const Build build : {Build::kMedium, Build::kLowDynamic, Build::kRefit}) {
      if (build == Build::kRefit && !change.can_refit) continue;
      const auto moving = change.make(hall);
      CommittedScene scene(library, moving->content(), build);
      RayBuffer rays = RaySource(hall).Make(*FindRayKind("primary"), 64, [](RayBuffer&) {});
      for (int frame = 0; frame < 3; ++frame) {
        moving->Advance();
        scene.Recommit(moving->content(), moving->change());
        EXPECT_GT(scene.commit_seconds(), 0);
        rays.Rearm();
        scene.Trace(Query::kClosest, kIncoherentStream, rays.rays());
        const HitShares hits(Query::kClosest, rays);
        EXPECT_GT(hits.hits(), 0.3);
        const CommittedScene fresh(library, moving->content(), Build::kMedium);
        rays.Rearm();
        fresh.Trace(Query::kClosest, kIncoherentStream, rays.rays());
        EXPECT_NO_THROW(hits.Check(rays)) << path << ", " << Name(build) << ", frame " << frame;
      }
    }
  }
}

TEST_P(ChangeTest, BothLibrariesAreMeasured) {
  const BenchScene room = RoomForEmbree();
  for (const int threads : {1, 2}) {
    MovingContest contest(room, *FindChangeKind(GetParam()), threads);
    for (const std::string& kind : MovingRayKinds()) {
      const MovingCell cell{"room", GetParam(), kind, "1K", threads};
      const auto result = contest.Measure(cell, 2, [](const std::string&) {});
      ASSERT_TRUE(result);
      EXPECT_EQ(result->cell, cell);
      EXPECT_GT(result->rays, 300u);
      EXPECT_GT(result->Ratio(), 0);
      EXPECT_GE(result->equal_hits, 0.99);
      EXPECT_GE(result->embree.commit.size(), 2u);
      EXPECT_EQ(result->embree.stream.size(), result->embree.commit.size());
      EXPECT_EQ(result->dacrt.stream.size(), result->embree.commit.size());
      EXPECT_FALSE(result->embree_best.empty());
    }
  }
}

std::vector<const char*> ChangeNames() {
  std::vector<const char*> names;
  for (const ChangeKind& change : ChangeKinds()) names.push_back(change.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Changes, ChangeTest, testing::ValuesIn(ChangeNames()),
                         [](const testing::TestParamInfo<const char*>& info) {
                           std::string name = info.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

MovingResult MakeResult(const char* change, const char* size, double embree, double dacrt) {
  // A third of the time is the commit.
  return {.cell = {"a", change, "diffuse", size, 1},
          .triangles = 5,
          .rays = 6,
          .equal_hits = 1,
          .embree_best = "avx2 refit coherent stream",
          .embree = {{embree / 3}, {embree * 2 / 3}},
          .dacrt = {{dacrt / 3}, {dacrt * 2 / 3}}};
}

TEST(MovingGoalsTest, EachFigureTakesItsCells) {
  MovingResults results{};
  for (const Goal& goal : JudgeGoals(results)) EXPECT_FALSE(goal.IsMet()) << goal.figure;
  results.cells = {MakeResult("wave", "1K", 4, 1),        MakeResult("wave", "1M", 1, 1),
                   MakeResult("replaced", "1K", 1.5, 1),  MakeResult("instances", "1K", 9, 1),
                   MakeResult("one-of-1000", "1K", 1, 1), MakeResult("growing", "1K", 0.1, 1)};
  const std::vector<double> expected = {2, 1, 1.5, 1.5, 3, 1};
  const std::vector<Goal> goals = JudgeGoals(results);
  ASSERT_EQ(goals.size(), expected.size());
  for (std::size_t i = 0; i < goals.size(); ++i) {
    EXPECT_NEAR(*goals[i].measured, expected[i], 1e-9) << goals[i].figure;
  }
  EXPECT_EQ(goals.back().worst, "one-of-1000");
}

TEST(MovingResultsTest, CellsSurviveTheFile) {
  MovingResults results{};
  results.cells = {MakeResult("wave", "1K", 4, 1), MakeResult("growing", "1M", 4, 3)};
  MovingResults read{};
  AddCells(nlohmann::ordered_json::parse(ToJson(results).dump()), read);
  EXPECT_EQ(ToJson(read), ToJson(results));
  EXPECT_EQ(read.cells.at(1).cell, results.cells[1].cell);
  EXPECT_THROW(AddCells({{"benchmark", "method_bench"}}, read), nlohmann::json::exception);
}

TEST(MovingCellsTest, SettingsHaveEveryCellOnceAndInOrder) {
  for (const auto& blocks : {ShortMovingBlocks("", {1, 2}), FullMovingBlocks("", {1, 2})}) {
    const std::vector<MovingCell> cells = CellsOf(blocks);
    std::vector<MovingCell> firsts;
    MovingResults results{};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      EXPECT_EQ(std::ranges::count(cells, cells[i]), 1) << Name(cells[i]);
      if (i == 0 || !AreMeasuredTogether(cells[i - 1], cells[i])) firsts.push_back(cells[i]);
      results.cells.push_back(MakeResult(cells[i].change.c_str(), "1K", 1, 1));
    }
    for (const MovingCell& first : firsts) {
      EXPECT_EQ(std::ranges::count_if(
                    firsts, [&](const auto& cell) { return AreMeasuredTogether(cell, first); }),
                1)
          << Name(first);
    }
    for (const Goal& goal : JudgeGoals(results)) EXPECT_GT(goal.cells, 0u) << goal.figure;
  }
}

}  // namespace
}  // namespace dacrt::bench
