#include "embree_contest.h"

#include <vector>

#include "cell_list.h"
#include "hit_shares.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

// The drop-in is told nothing of how coherent the rays are: it finds out itself.
constexpr bool kSaysCoherent = false;
// It splits with care what is to last (README.md), which the program says to both libraries.
constexpr Build kDropInBuild = Build::kMedium, kDropInOneShot = Build::kLowDynamic;

// There are more rounds than asked for while they are short, up to a multiple.
constexpr int kMostRoundsFactor = 5;

std::vector<Build> Builds(bool anew) {
  if (!anew) return {Build::kMedium, Build::kHigh};
  return {Build::kMedium, Build::kHigh, Build::kLow, Build::kLowDynamic};
}

// A batch that is one stream, in one call; else as Embree is called.
Delivery DropInDelivery(const BatchSize& size, std::size_t batch, std::size_t run, int threads) {
  const Call call{size.Calls().front().form, kSaysCoherent};
  if (!size.IsStream()) return DeliveryOfCalls(call, batch, threads);
  return {call, run, batch, run == batch ? 1 : threads};
}

}  // namespace

EmbreeContest::EmbreeContest(const BenchScene& scene, const SceneContent& content,
                             const ContestSetup& setup, const Effort& effort)
    : scene_(scene),
      content_(content),
      setup_(setup),
      effort_(effort),
      embree_(setup.embree, content, setup.isa, setup.threads, Builds(setup.anew), setup.anew),
      drop_in_(setup.drop_in, DeviceConfig(setup.isa, setup.threads)),
      rays_(scene, content.needs) {}

RayBuffer EmbreeContest::MakeRays(const Cell& cell) {
  const std::uint32_t side = FindBatchSize(cell.size)->PictureSide(effort_.sliced_side);
  return rays_.Make(*FindRayKind(cell.kind), side, [this](RayBuffer& primary) {
    // A scene of its own: the one that is measured has seen no rays.
    const CommittedScene scene(drop_in_, content_, kDropInBuild);
    scene.Trace(Query::kClosest, kIncoherentStream, primary.rays());
  });
}

const CommittedScene& EmbreeContest::StillDropIn() {
  if (!still_drop_in_) still_drop_in_.emplace(drop_in_, content_, kDropInBuild);
  return *still_drop_in_;
}

CellResult EmbreeContest::Measure(const Cell& cell, const OnStep& on_step, RayBuffer& rays) {
  const Query query = FindRayKind(cell.kind)->query;
  const BatchSize& size = *FindBatchSize(cell.size);
  const std::size_t batch = size.RaysOfBatch(rays.rays().size());
  const std::size_t run = size.RaysOfRun(rays.rays().size(), setup_.threads);
  RayBuffer middle = rays.Part((rays.rays().size() - batch) / 2, size.IsSlice() ? batch : 0);
  RayBuffer& first_batch = size.IsSlice() ? middle : rays;

  on_step("first calls");
  rays.Keep(rays.rays().size() / run * run);
  const CommittedScene& still_dacrt = StillDropIn();
  const Delivery to_fresh = DropInDelivery(size, batch, batch, setup_.threads);
  const Delivery to_still = DropInDelivery(size, batch, run, setup_.threads);
  const std::size_t runs = DeliverFor(effort_.slices_seconds, still_dacrt, query, to_still, rays);
  rays.Keep(runs * run);
  const std::size_t batches = runs * run / batch;
  const HitShares hits(query, rays);

  on_step("looking for Embree's best");
  const EmbreeAtBest::Best best = embree_.Find(query, size, batch, run, rays);
  hits.Check(rays);

  // What rays pay for is bought by then but where next to none come.
  on_step("until it is steady");
  const Stopwatch warming;
  while (warming.Seconds() < effort_.warm_seconds) Deliver(still_dacrt, query, to_still, rays);

  const CommittedScene& still_embree = embree_.StillScene(best.steady);
  EmbreeVariant high = best.steady;
  high.build = Build::kHigh;
  const CommittedScene& still_high = embree_.StillScene(high);
  const bool anew = setup_.anew && MeasuresOneShot(cell);
  CellResult result{.cell = cell,
                    .triangles = scene_.TriangleCount(),
                    .rays = batch,
                    .batches = batches,
                    .hits = hits.hits(),
                    .equal_hits = hits.Equal(rays),
                    .embree_one_shot = anew ? Name(best.one_shot) : "",
                    .embree_steady = Name(best.steady),
                    .embree = {},
                    .dacrt = {},
                    .high_steady = {}};
  const auto one_shot = [&](const EmbreeLibrary& library, Build build, const Delivery& delivery,
                            Times& times) {
    const CommittedScene fresh(library, content_, build);
    times.commit.push_back(fresh.commit_seconds());
    times.first.push_back(Deliver(fresh, query, delivery, first_batch));
  };
  const auto steady = [&](const CommittedScene& scene, const Delivery& delivery,
                          std::vector<double>& seconds) {
    seconds.push_back(Deliver(scene, query, delivery, rays) / batches);
  };
  const Stopwatch stopwatch;
  for (int round = 0; round < effort_.repeat || (round < effort_.repeat * kMostRoundsFactor &&
                                                 stopwatch.Seconds() < effort_.rounds_seconds);
       ++round) {
    on_step("round " + std::to_string(round + 1));
    if (anew) {
      one_shot(embree_.Library(best.one_shot), best.one_shot.build, best.one_shot.delivery,
               result.embree);
      one_shot(drop_in_, kDropInOneShot, to_fresh, result.dacrt);
    }
    steady(still_embree, best.steady.delivery, result.embree.steady);
    steady(still_dacrt, to_still, result.dacrt.steady);
    steady(still_high, high.delivery, result.high_steady);
  }
  return result;
}

}  // namespace dacrt::bench
