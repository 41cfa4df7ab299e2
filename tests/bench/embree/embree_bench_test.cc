// The parts of the comparison with Embree.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "batch_size.h"
#include "callers.h"
#include "delivery.h"
#include "embree_at_best.h"
#include "embree_results.h"
#include "goals.h"
#include "memory_child.h"
#include "ray_kind.h"
#include "room.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

TEST(CallersTest, EveryNumberIsTakenOnceByOneOfAsManyThreads) {
  for (const int count : {1, 2, 5}) {
    Callers callers(count);
    for (const std::size_t calls : {0, 1, 2, 100}) {
      std::vector<std::atomic<int>> taken(calls);
      callers.Run(calls, [&](std::size_t i) { ++taken[i]; });
      EXPECT_TRUE(std::ranges::all_of(taken, [](int times) { return times == 1; }))
          << count << " callers, " << calls << " calls";
    }
  }
}

TEST(CallersTest, CallsRunAtTheSameTime) {
  // Each waits for the other, though not for ever.
  Callers callers(2);
  std::atomic<int> started = 0;
  std::atomic<int> met = 0;
  callers.Run(2, [&](std::size_t) {
    ++started;
    const Stopwatch stopwatch;
    while (started < 2 && stopwatch.Seconds() < 10) std::this_thread::yield();
    if (started == 2) ++met;
  });
  EXPECT_EQ(met, 2);
}

TEST(BatchSizeTest, SlicesComeFromAPictureAndLargerBatchesAreOne) {
  for (const BatchSize& size : BatchSizes()) {
    const std::size_t picture = size.Picture().RayCount();
    EXPECT_EQ(picture, std::max<std::size_t>(size.rays, size.IsSlice() ? 512 * 512 : 0))
        << size.name;
    EXPECT_EQ(size.RaysOfCall(picture), size.rays) << size.name;
    EXPECT_EQ(FindBatchSize(size.name), &size);
    // Not every primary ray has one of the kind: a slice is full, a picture has fewer.
    EXPECT_EQ(size.RaysOfCall(50'000), size.IsSlice() ? size.rays : 50'000) << size.name;
    EXPECT_EQ(size.RaysOfCall(10), 10u) << size.name;
  }
  EXPECT_EQ(FindBatchSize("2M"), nullptr);
}

TEST(SliceSizesTest, EveryThreadHasWork) {
  EXPECT_EQ(SliceSizes(64, 1), (std::vector<std::size_t>{64}));
  EXPECT_EQ(SliceSizes(1 << 20, 1), (std::vector<std::size_t>{1 << 20}));
  EXPECT_EQ(SliceSizes(64, 2), (std::vector<std::size_t>{32, 64}));
  EXPECT_EQ(SliceSizes(65, 2), (std::vector<std::size_t>{33, 65}));
  for (const std::size_t slice : SliceSizes(65'536, 2)) EXPECT_GE(65'536 / slice, 4u);
}

class DeliveryTest : public testing::Test {
 protected:
  DeliveryTest() { room_.mesh.positions.push_back(0); }  // Embree reads it with the last vertex

  static RayBuffer CameraRays(const BenchScene& scene) {
    RayBuffer rays(kSide * kSide);
    RayGeneration(scene).MakeCameraRays(Raster(kSide), false, rays);
    return rays;
  }

  static std::size_t CountHits(const RayBuffer& rays) {
    return std::ranges::count_if(
        rays.rays(), [](const RayRecord& ray) { return ray.geometry_id != kNoGeometry; });
  }

  static constexpr uint32_t kSide = 100;
  static constexpr std::size_t kRays = kSide * kSide;
  BenchScene room_ = Room();
  RayBuffer rays_ = CameraRays(room_);
};

TEST_F(DeliveryTest, EveryRayIsTracedHoweverTheyAreCut) {
  for (const char* const path : {DACRT_REAL_EMBREE, DACRT_DROP_IN}) {
    const EmbreeLibrary library(path, "threads=2");
    const CommittedScene scene(library, room_, RTC_BUILD_QUALITY_MEDIUM);
    for (const std::size_t batch : {kRays, std::size_t{4096}, std::size_t{7}}) {
      for (const std::size_t slice : {batch, std::size_t{1000}, std::size_t{3}}) {
        for (const Call call :
             {Call::kCoherentStream, Call::kIncoherentStream, Call::kSingleRays}) {
          const double seconds = Deliver(scene, Query::kClosest, {call, batch, slice, 2}, rays_);
          EXPECT_GT(seconds, 0);
          EXPECT_EQ(CountHits(rays_), kRays)  // the room is closed
              << path << ", " << Name(call) << ", " << batch << ", " << slice;
        }
      }
    }
  }
}

TEST_F(DeliveryTest, StopsWhenTheTimeIsOver) {
  const EmbreeLibrary library(DACRT_REAL_EMBREE, "threads=1");
  const CommittedScene scene(library, room_, RTC_BUILD_QUALITY_MEDIUM);
  const Delivery delivery{Call::kIncoherentStream, 64, 64, 1};
  EXPECT_EQ(DeliverFor(1e-9, scene, Query::kClosest, delivery, rays_), 1u);
  EXPECT_EQ(CountHits(rays_), 64u);
  EXPECT_EQ(DeliverFor(1e9, scene, Query::kClosest, delivery, rays_), (kRays + 63) / 64);
  EXPECT_EQ(CountHits(rays_), kRays);
}

TEST_F(DeliveryTest, EmbreesBestIsOneOfTheVariantsOfItsThreads) {
  for (const int threads : {1, 2}) {
    const EmbreeAtBest embree(room_, threads);
    const EmbreeAtBest::Best best = embree.Find(Query::kAny, kRays, rays_);
    for (const EmbreeVariant& variant : {best.one_shot, best.steady}) {
      EXPECT_EQ(variant.delivery.batch, kRays);
      EXPECT_EQ(variant.delivery.callers, threads);
      // This one does not return from every scene.
      EXPECT_FALSE(variant.isa == "avx512" && variant.delivery.call == Call::kCoherentStream);
      EXPECT_GT(Deliver(embree.StillScene(variant), Query::kAny, variant.delivery, rays_), 0);
    }
  }
}

TEST(RaySourceTest, PrimaryHitsAreTracedOnceAPicture) {
  const BenchScene room = Room();
  const TriangleMesh mesh = room.AsTriangleMesh();
  const Scene scene(std::make_shared<Device>(), std::span(&mesh, 1));
  int traced = 0;
  const auto trace = [&](RayBuffer& rays) {
    ++traced;
    scene.Trace(Query::kClosest, rays.View());
  };
  RaySource source(room);
  for (const RayKind& kind : RayKinds()) {
    const RayBuffer rays = source.Make(kind, Raster(64), trace);
    EXPECT_GT(rays.rays().size(), 64u * 64 / 4) << kind.name;
    EXPECT_EQ(FindRayKind(kind.name), &kind);
  }
  EXPECT_EQ(traced, 1);
  EXPECT_EQ(source.Make(*FindRayKind("diffuse"), Raster(32), trace).rays().size(), 32u * 32);
  EXPECT_EQ(traced, 2);
}

CellResult MakeCell(Cell cell, double embree, double dacrt) {
  // Commit and first call together take ten times as long as a later call.
  return {.cell = cell,
          .triangles = 1'000'000,
          .rays = 1,
          .batches = 1,
          .embree_one_shot = "avx2",
          .embree_steady = "avx512",
          .embree = {{embree * 9}, {embree}, {embree}},
          .dacrt = {{dacrt * 4}, {dacrt}, {dacrt}}};
}

const Goal& Find(const std::vector<Goal>& goals, const std::string& figure, Goal::Judged judged) {
  const auto found = std::ranges::find_if(
      goals, [&](const Goal& goal) { return goal.figure == figure && goal.judged == judged; });
  EXPECT_NE(found, goals.end()) << figure;
  return *found;
}

constexpr Goal::Judged kMean = Goal::Judged::kGeometricMean;
constexpr Goal::Judged kWorst = Goal::Judged::kWorstCell;

TEST(GoalsTest, WithoutCellsNothingIsMeasuredAndNothingIsMet) {
  for (const Goal& goal : JudgeGoals({})) {
    EXPECT_EQ(goal.cells, 0u) << goal.figure;
    EXPECT_FALSE(goal.measured) << goal.figure;
    EXPECT_FALSE(goal.IsMet()) << goal.figure;
  }
}

TEST(GoalsTest, EachFigureTakesItsCells) {
  EmbreeResults results{};
  results.cells = {
      MakeCell({"a", "primary", "64", 1}, 0.5, 1), MakeCell({"a", "primary", "4K", 1}, 0.7, 1),
      MakeCell({"a", "primary", "64K", 1}, 1, 1),  MakeCell({"a", "primary", "1M", 1}, 4, 1.8),
      MakeCell({"a", "primary", "1M", 2}, 4, 1),   MakeCell({"a", "diffuse", "16M", 1}, 3, 1)};
  const std::vector<Goal> goals = JudgeGoals(results);

  // One shot is twice the steady ratio.
  EXPECT_EQ(Find(goals, "one shot, from 64K rays", kMean).cells, 4u);
  EXPECT_DOUBLE_EQ(*Find(goals, "one shot", kWorst).measured, 1.0);
  EXPECT_TRUE(Find(goals, "one shot", kWorst).IsMet());
  EXPECT_EQ(Find(goals, "one shot", kWorst).worst_cell, "a, primary, 64, 1 thread");

  const Goal& steady = Find(goals, "steady, from 64K rays", kMean);
  EXPECT_EQ(steady.cells, 4u);
  EXPECT_NEAR(*steady.measured, std::pow(1 * (4 / 1.8) * 4 * 3, 1.0 / 4), 1e-12);
  EXPECT_TRUE(steady.IsMet());
  EXPECT_DOUBLE_EQ(*Find(goals, "steady, from 64K rays", kWorst).measured, 1);

  EXPECT_DOUBLE_EQ(*Find(goals, "steady, 4,096 rays a call", kMean).measured, 0.7);
  EXPECT_FALSE(Find(goals, "steady, 4,096 rays a call", kMean).IsMet());
  EXPECT_DOUBLE_EQ(*Find(goals, "steady, 64 rays a call", kWorst).measured, 0.5);
  EXPECT_TRUE(Find(goals, "steady, 64 rays a call", kWorst).IsMet());
  EXPECT_DOUBLE_EQ(*Find(goals, "16M diffuse rays, trace against trace", kWorst).measured, 3);

  const Goal& speedup = Find(goals, "2 threads against 1, from 1M rays", kWorst);
  EXPECT_EQ(speedup.cells, 1u);
  EXPECT_DOUBLE_EQ(*speedup.measured, 1.8);
  EXPECT_EQ(speedup.worst_cell, "a, primary, 1M, 2 threads");
}

TEST(GoalsTest, MemoryIsJudgedByItsMost) {
  EmbreeResults results{};
  const auto add = [&](const char* size, std::size_t triangles, std::size_t kept,
                       std::size_t peak) {
    results.memory.push_back({.cell = {"a", "diffuse", size, 1},
                              .triangles = triangles,
                              .rays = 1,
                              .embree = {1, 2, 3, 100 * triangles},
                              .dacrt = {1, 2, kept, peak}});
  };
  add("64K", 1'000'000, 7'000'000, 10'000'000);
  add("1M", 1'000'000, 9'000'000, 20'000'000);
  add("1M", 75'000, 75'000, 75'000 * 90);  // a small mesh's peak is no goal
  const std::vector<Goal> goals = JudgeGoals(results);
  const Goal& kept = Find(goals, "kept between calls, bytes a triangle", kWorst);
  EXPECT_EQ(kept.cells, 3u);
  EXPECT_DOUBLE_EQ(*kept.measured, 9);
  EXPECT_FALSE(kept.IsMet());
  const Goal& peak = Find(goals, "peak over Embree's, from 1M triangles, up to 1M rays", kWorst);
  EXPECT_EQ(peak.cells, 2u);
  EXPECT_DOUBLE_EQ(*peak.measured, 0.2);
  EXPECT_TRUE(peak.IsMet());
}

TEST(EmbreeResultsTest, CellsSurviveTheFile) {
  EmbreeResults results{};
  results.cells = {MakeCell({"hall-1m", "diffuse", "64K", 2}, 3, 2)};
  results.memory = {{.cell = {"hall-1m", "diffuse", "1M", 1},
                     .triangles = 5,
                     .rays = 6,
                     .embree = {1, 2, 3, 4},
                     .dacrt = {5, 6, 7, 8}}};
  EmbreeResults read{};
  AddCells(nlohmann::ordered_json::parse(ToJson(results).dump()), read);
  EXPECT_EQ(ToJson(read), ToJson(results));
  EXPECT_EQ(read.cells.at(0).cell, results.cells[0].cell);
  EXPECT_DOUBLE_EQ(read.cells[0].OneShotRatio(), 3.0);
  EXPECT_EQ(read.memory.at(0).dacrt.peak_resident, 8u);
  EXPECT_THROW(AddCells({{"benchmark", "method_bench"}}, read), nlohmann::json::exception);
}

TEST(MemoryTest, AChildFindsWhatALibraryAllocates) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer keeps what is freed, and shadows the rest";
#endif
  BenchScene hall = SceneSource("hall-75k", "").Load();
  hall.mesh.positions.push_back(0);  // Embree reads it with the last vertex
  RayBuffer rays(64 * 64);
  RayGeneration(hall).MakeCameraRays(Raster(64), false, rays);
  const double triangles = hall.TriangleCount();

  // Some sixty bytes a triangle when it is built, some hundred at the peak.
  const MemoryUse embree = MeasureMemoryInChild(DACRT_REAL_EMBREE, "threads=1", hall, rays);
  EXPECT_GT(embree.kept_announced / triangles, 40);
  EXPECT_LT(embree.kept_announced / triangles, 120);
  EXPECT_GT(embree.peak_announced, embree.kept_announced);
  EXPECT_GT(embree.kept_resident / triangles, 40);
  EXPECT_LT(embree.kept_resident / triangles, 120);
  EXPECT_GT(embree.peak_resident, embree.kept_resident);

  // At the least a reference to each triangle during the call.
  const MemoryUse dacrt = MeasureMemoryInChild(DACRT_DROP_IN, "threads=1", hall, rays);
  EXPECT_GT(dacrt.peak_resident / triangles, 4);
  EXPECT_GE(dacrt.peak_resident, dacrt.kept_resident);

  EXPECT_THROW(MeasureMemoryInChild(DACRT_DROP_IN, "dacrt_colour=red", hall, rays),
               std::runtime_error);
}

}  // namespace
}  // namespace dacrt::bench
