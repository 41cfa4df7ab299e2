// The parts of the comparison with Embree.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
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
#include "geometry_kind.h"
#include "isa.h"
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
  constexpr std::uint32_t kSide = 128;
  for (const BatchSize& size : BatchSizes()) {
    const std::size_t side = size.PictureSide(kSide);
    EXPECT_EQ(side * side, size.IsSlice() ? kSide * kSide : size.rays) << size.name;
    EXPECT_EQ(FindBatchSize(size.name), &size);
    // Not every primary ray has one of the kind: a slice is full, a picture has fewer.
    if (size.IsStream()) {
      EXPECT_EQ(size.RaysOfBatch(50'000), size.IsSlice() ? size.rays : 50'000) << size.name;
      EXPECT_EQ(size.RaysOfBatch(10), 10u) << size.name;
    } else {
      EXPECT_EQ(size.RaysOfBatch(50) % size.rays, 0u) << size.name;
      EXPECT_GT(size.RaysOfBatch(50) + size.rays, 50u) << size.name;
    }
    for (const Call& call : size.Calls()) {
      EXPECT_TRUE(call.PacketWidth() == size.rays || size.IsStream()) << size.name;
    }
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

TEST(RayCallTest, PacketsAreTransposedRecords) {
  for (const std::size_t width : {4, 8, 16}) {
    RayBuffer rays(64);
    rays.Begin(7);
    for (int i = 0; i < 64; ++i) rays.Append({1.0f * i, 2, 3}, {4, 5, 6}, i);
    MakePackets(width, rays.rays());
    const auto words = reinterpret_cast<const float*>(rays.rays().data());
    const std::size_t second = width * sizeof(RayRecord) / sizeof(float);
    EXPECT_EQ(words[1], 1) << "org_x of the second ray";
    EXPECT_EQ(words[width], 2) << "org_y of the first";
    EXPECT_EQ(words[second], width) << "org_x of the first of the second packet";
    MakeRecords(width, rays.rays());
    for (uint32_t i = 0; i < 64; ++i) {
      EXPECT_EQ(rays.rays()[i].org[0], i);
      EXPECT_EQ(rays.rays()[i].dir[2], 6);
      EXPECT_EQ(rays.rays()[i].id, i);
      EXPECT_EQ(rays.rays()[i].instance_id, kNoGeometry);
    }
  }
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

  static constexpr uint32_t kSide = 96;
  static constexpr std::size_t kRays = kSide * kSide;
  BenchScene room_ = Room();
  SceneContent content_ = FindGeometryKind("triangles")->make(room_);
  RayBuffer rays_ = CameraRays(room_);
};

TEST_F(DeliveryTest, EveryRayIsTracedHoweverTheyAreSent) {
  for (const char* const path : {DACRT_REAL_EMBREE, DACRT_DROP_IN}) {
    const EmbreeLibrary library(path, "threads=2");
    const CommittedScene scene(library, content_, Build::kMedium);
    for (const BatchSize& size : BatchSizes()) {
      for (const Call& call : size.Calls()) {
        for (const std::size_t batch : {kRays, std::size_t{4096}, std::size_t{48}}) {
          for (const std::size_t slice : {batch, std::size_t{1024}, std::size_t{16}}) {
            const double seconds = Deliver(scene, Query::kClosest, {call, batch, slice, 2}, rays_);
            EXPECT_GT(seconds, 0);
            EXPECT_EQ(CountHits(rays_), kRays)  // the room is closed
                << path << ", " << Name(call) << ", " << batch << ", " << slice;
          }
        }
      }
    }
  }
}

TEST_F(DeliveryTest, StopsWhenTheTimeIsOver) {
  const EmbreeLibrary library(DACRT_REAL_EMBREE, "threads=1");
  const CommittedScene scene(library, content_, Build::kMedium);
  const Delivery delivery{kIncoherentStream, 64, 64, 1};
  EXPECT_EQ(DeliverFor(1e-9, scene, Query::kClosest, delivery, rays_), 1u);
  EXPECT_EQ(CountHits(rays_), 64u);
  EXPECT_EQ(DeliverFor(1e9, scene, Query::kClosest, delivery, rays_), (kRays + 63) / 64);
  EXPECT_EQ(CountHits(rays_), kRays);
}

TEST_F(DeliveryTest, EmbreesBestIsOneOfTheVariantsOfItsThreads) {
  constexpr Build kBuilds[] = {Build::kMedium, Build::kHigh, Build::kLow, Build::kLowDynamic};
  const std::string isa = IsasHere().front();
  for (const int threads : {1, 2}) {
    const EmbreeAtBest embree(DACRT_REAL_EMBREE, content_, isa, threads, kBuilds, true);
    for (const char* const name : {"1", "8", "64", "4K"}) {
      const BatchSize& size = *FindBatchSize(name);
      const std::size_t batch = size.RaysOfBatch(kRays);
      const std::size_t run = size.RaysOfRun(kRays, threads);
      const EmbreeAtBest::Best best = embree.Find(Query::kAny, size, batch, run, rays_);
      EXPECT_EQ(best.one_shot.delivery.batch, batch);
      EXPECT_EQ(best.steady.delivery.batch, run);
      EXPECT_TRUE(run == batch || best.steady.delivery.slice == size.rays);
      for (const EmbreeVariant& variant : {best.one_shot, best.steady}) {
        EXPECT_EQ(variant.delivery.callers, threads);
        EXPECT_NE(variant.build, Build::kHigh);
        EXPECT_NE(std::ranges::find(size.Calls(), variant.delivery.call), size.Calls().end());
        // This one does not return from every scene.
        EXPECT_FALSE(variant.isa == "avx512" && variant.delivery.call.is_coherent);
        EXPECT_GT(Deliver(embree.StillScene(variant), Query::kAny, variant.delivery, rays_), 0);
      }
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
    const RayBuffer rays = source.Make(kind, 64, trace);
    EXPECT_GT(rays.rays().size(), 64u * 64 / 4) << kind.name;
    EXPECT_EQ(FindRayKind(kind.name), &kind);
  }
  EXPECT_EQ(traced, 2) << "one ray a pixel, and four";
  EXPECT_EQ(source.Make(*FindRayKind("diffuse"), 32, trace).rays().size(), 32u * 32);
  EXPECT_EQ(traced, 3);
}

TEST(RaySourceTest, RaysHaveTheTimesAndMasksThatTheSceneNeeds) {
  const BenchScene room = Room();
  const auto trace = [](RayBuffer&) {};
  const RayKind& primary = *FindRayKind("primary");
  const auto count = [](const RayBuffer& rays, const auto& is_counted) {
    return std::ranges::count_if(rays.rays(), is_counted);
  };
  const RayBuffer masked = RaySource(room, {.masks = true}).Make(primary, 64, trace);
  const auto sees_half = count(masked, [](const RayRecord& ray) { return ray.mask == 1; });
  EXPECT_GT(sees_half, 64 * 64 / 3);
  EXPECT_LT(sees_half, 64 * 64 * 2 / 3);
  const RayBuffer timed = RaySource(room, {.times = true}).Make(primary, 64, trace);
  EXPECT_GT(count(timed, [](const RayRecord& ray) { return ray.time > 0.5f; }), 64 * 64 / 3);
  EXPECT_EQ(timed.Part(1, 5).rays()[4].time, timed.rays()[5].time) << "a part keeps them";
}

TEST(MemoryTest, AChildFindsWhatALibraryAllocates) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the sanitizer keeps what is freed, and shadows the rest";
#endif
  const BenchScene hall = SceneSource("hall-75k", "").LoadForEmbree();
  RayBuffer rays(64 * 64);
  RayGeneration(hall).MakeCameraRays(Raster(64), false, rays);
  const double triangles = hall.TriangleCount();

  // Some sixty bytes a triangle when it is built, some hundred at the peak.
  const MemoryUse embree =
      MeasureMemoryInChild(DACRT_REAL_EMBREE, "threads=1", hall, "triangles", rays);
  EXPECT_GT(embree.kept_announced / triangles, 40);
  EXPECT_LT(embree.kept_announced / triangles, 120);
  EXPECT_GT(embree.peak_announced, embree.kept_announced);
  EXPECT_GT(embree.kept_resident / triangles, 40);
  EXPECT_LT(embree.kept_resident / triangles, 120);
  EXPECT_GT(embree.peak_resident, embree.kept_resident);
  EXPECT_LT(embree.left_resident, embree.kept_resident);

  // At the least a reference to each triangle during the call.
  const MemoryUse dacrt = MeasureMemoryInChild(DACRT_DROP_IN, "threads=1", hall, "triangles", rays);
  EXPECT_GT(dacrt.peak_resident / triangles, 4);
  EXPECT_GE(dacrt.peak_resident, dacrt.kept_resident);
  EXPECT_GE(dacrt.kept_resident, dacrt.left_resident);

  EXPECT_THROW(MeasureMemoryInChild(DACRT_DROP_IN, "dacrt_colour=red", hall, "triangles", rays),
               std::runtime_error);
}

}  // namespace
}  // namespace dacrt::bench
