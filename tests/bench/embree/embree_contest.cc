#include "embree_contest.h"

#include <algorithm>

#include "batch_size.h"
#include "errors.h"
#include "memory_child.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

// What the drop-in is called with: it finds out itself how coherent the rays are.
constexpr Call kDropInCall = Call::kIncoherentStream;
// It has no tree to build, well or badly.
constexpr RTCBuildQuality kDropInQuality = RTC_BUILD_QUALITY_MEDIUM;

// As many slices are measured as it takes this long to trace once: all of them, unless a library is
// very slow.
constexpr double kSlicesSeconds = 0.5;

// Times of a millisecond vary: there are more rounds than asked for until they have taken this
// long, up to a multiple.
constexpr double kRoundsSeconds = 0.5;
constexpr int kMostRoundsFactor = 5;

std::size_t CountHits(Query query, const RayBuffer& rays) {
  return std::ranges::count_if(rays.rays(), [query](const RayRecord& ray) {
    return query == Query::kAny ? ray.tfar < 0 : ray.geometry_id != kNoGeometry;
  });
}

void CheckHits(std::size_t embree, std::size_t dacrt, std::size_t rays) {
  constexpr double kTolerance = 1e-4;  // of the rays: edges and ends decided the other way
  const double apart = embree > dacrt ? embree - dacrt : dacrt - embree;
  if (apart <= kTolerance * rays + 1) return;
  throw Disagreement("Embree finds " + std::to_string(embree) + " hits and dacrt " +
                     std::to_string(dacrt) + " with the same " + std::to_string(rays) + " rays");
}

}  // namespace

EmbreeContest::EmbreeContest(const BenchScene& scene, int threads)
    : scene_(scene),
      config_("threads=" + std::to_string(threads)),
      embree_(scene, threads),
      drop_in_(DACRT_DROP_IN, config_),
      rays_(scene) {}

RayBuffer EmbreeContest::MakeRays(const Cell& cell) {
  const Raster picture = FindBatchSize(cell.size)->Picture();
  return rays_.Make(*FindRayKind(cell.kind), picture, [this](RayBuffer& primary) {
    // A scene of its own: those that are measured have seen no rays.
    const CommittedScene scene(drop_in_, scene_, kDropInQuality);
    scene.Trace(Query::kClosest, kDropInCall, primary.rays());
  });
}

CellResult EmbreeContest::Measure(const Cell& cell, int repeat, const OnStep& on_step,
                                  RayBuffer& rays) const {
  const Query query = FindRayKind(cell.kind)->query;
  const BatchSize& size = *FindBatchSize(cell.size);
  const std::size_t batch = size.RaysOfCall(rays.rays().size());
  const Delivery to_drop_in = {kDropInCall, batch, batch, 1};
  RayBuffer middle = rays.Part((rays.rays().size() - batch) / 2, size.IsSlice() ? batch : 0);
  RayBuffer& first_batch = size.IsSlice() ? middle : rays;

  on_step("first calls");
  rays.Keep(rays.rays().size() / batch * batch);
  const CommittedScene still_dacrt(drop_in_, scene_, kDropInQuality);
  const std::size_t batches = DeliverFor(kSlicesSeconds, still_dacrt, query, to_drop_in, rays);
  rays.Keep(batches * batch);
  const std::size_t dacrt_hits = CountHits(query, rays);

  on_step("looking for Embree's best");
  const EmbreeAtBest::Best best = embree_.Find(query, batch, rays);
  const CommittedScene& still_embree = embree_.StillScene(best.steady);
  Deliver(still_embree, query, best.steady.delivery, rays);
  CheckHits(CountHits(query, rays), dacrt_hits, rays.rays().size());

  CellResult result{.cell = cell,
                    .triangles = scene_.TriangleCount(),
                    .rays = batch,
                    .batches = batches,
                    .embree_one_shot = Name(best.one_shot),
                    .embree_steady = Name(best.steady),
                    .embree = {},
                    .dacrt = {}};
  const auto one_shot = [&](const EmbreeLibrary& library, RTCBuildQuality quality,
                            const Delivery& delivery, Times& times) {
    const CommittedScene fresh(library, scene_, quality);
    times.commit.push_back(fresh.commit_seconds());
    times.first.push_back(Deliver(fresh, query, delivery, first_batch));
  };
  const auto steady = [&](const CommittedScene& scene, const Delivery& delivery, Times& times) {
    times.steady.push_back(Deliver(scene, query, delivery, rays) / batches);
  };
  const Stopwatch stopwatch;
  for (int round = 0; round < repeat ||
                      (round < repeat * kMostRoundsFactor && stopwatch.Seconds() < kRoundsSeconds);
       ++round) {
    on_step("round " + std::to_string(round + 1));
    one_shot(embree_.Library(best.one_shot), best.one_shot.quality, best.one_shot.delivery,
             result.embree);
    one_shot(drop_in_, kDropInQuality, to_drop_in, result.dacrt);
    steady(still_embree, best.steady.delivery, result.embree);
    steady(still_dacrt, to_drop_in, result.dacrt);
  }
  return result;
}

MemoryResult EmbreeContest::MeasureMemory(const Cell& cell, RayBuffer& rays) const {
  return {.cell = cell,
          .triangles = scene_.TriangleCount(),
          .rays = rays.rays().size(),
          .embree = MeasureMemoryInChild(DACRT_REAL_EMBREE, config_, scene_, rays),
          .dacrt = MeasureMemoryInChild(DACRT_DROP_IN, config_, scene_, rays)};
}

}  // namespace dacrt::bench
