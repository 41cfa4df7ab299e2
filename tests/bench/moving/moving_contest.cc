#include "moving_contest.h"

#include <algorithm>
#include <span>

#include "embree_at_best.h"
#include "hit_shares.h"
#include "isa.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

// More frames than asked for while they are short, up to a multiple: who moves a scene shows it for
// more than a few.
constexpr double kFramesSeconds = 1;
constexpr int kMostFramesFactor = 20;

// Ways to use Embree that are measured to the end; the others are tried once.
constexpr std::size_t kFinalists = 2;

std::vector<Build> Builds(const ChangeKind& change) {
  std::vector<Build> builds = {Build::kMedium, Build::kLowDynamic};
  if (change.can_refit) builds.push_back(Build::kRefit);
  return builds;
}

}  // namespace

MovingContest::MovingContest(const BenchScene& scene, const ChangeKind& change, int threads)
    : scene_(scene),
      threads_(threads),
      content_(change.make(scene)),
      drop_in_library_(DACRT_DROP_IN, DeviceConfig(IsasHere().front(), threads)),
      drop_in_("dacrt", drop_in_library_, content_->content(), Build::kLowDynamic) {
  for (const std::string& isa : IsasWithin(IsasHere().front())) {
    const EmbreeLibrary& library =
        libraries_.emplace_back(DACRT_REAL_EMBREE, DeviceConfig(isa, threads));
    for (const Build build : Builds(change)) {
      embree_.emplace_back(isa + " " + Name(build), library, content_->content(), build);
    }
  }
  ray_maker_.emplace("rays", libraries_.front(), content_->content(), Build::kLowDynamic);
}

void MovingContest::Recommit(Entrant& entrant) const {
  entrant.scene.Recommit(content_->content(), content_->change());
}

RayBuffer MovingContest::MakeFrame(const RayKind& kind, std::uint32_t side) {
  content_->Advance();
  return RaySource(scene_).Make(kind, side, [this](RayBuffer& primary) {
    Recommit(*ray_maker_);
    ray_maker_->scene.Trace(Query::kClosest, kCoherentStream, primary.rays());
  });
}

// Each way once, on some of the rays of a frame.
std::vector<MovingContest::Candidate> MovingContest::FindBest(const RayKind& kind,
                                                              std::uint32_t side) {
  const RayBuffer rays = MakeFrame(kind, side);
  const std::size_t batch = rays.rays().size();
  if (batch == 0) return {};
  RayBuffer heat_rays = HeatRays(rays);
  std::vector<Candidate> candidates;
  for (Entrant& entrant : embree_) {
    Recommit(entrant);
    entrant.scene.Trace(kind.query, kIncoherentStream, heat_rays.rays());  // not the first alone
    for (const Call& call : {kIncoherentStream, kCoherentStream, kSingleRays}) {
      for (const std::size_t slice : SliceSizes(batch, threads_)) {
        const Delivery delivery{call, batch, slice, threads_};
        const double seconds = Deliver(entrant.scene, kind.query, delivery, heat_rays);
        const double of_batch = seconds / heat_rays.rays().size() * batch;
        candidates.push_back({&entrant, delivery, entrant.scene.commit_seconds() + of_batch, {}});
      }
    }
  }
  std::ranges::sort(candidates, {}, &Candidate::seconds);
  std::vector<Candidate> best;
  for (const Candidate& candidate : candidates) {
    const bool is_new =
        std::ranges::find(best, candidate.entrant, &Candidate::entrant) == best.end();
    if (is_new && best.size() < kFinalists) best.push_back(candidate);
  }
  return best;
}

std::optional<MovingResult> MovingContest::Measure(const MovingCell& cell, int repeat,
                                                   const OnStep& on_step) {
  const RayKind& kind = *FindRayKind(cell.kind);
  const std::uint32_t side = FindFrameSize(cell.size)->side;
  on_step("looking for Embree's best");
  std::vector<Candidate> finalists = FindBest(kind, side);
  if (finalists.empty()) return std::nullopt;
  MovingResult result{.cell = cell,
                      .triangles = scene_.TriangleCount(),
                      .rays = 0,
                      .equal_hits = 0,
                      .embree_best = "",
                      .embree = {},
                      .dacrt = {}};
  const Stopwatch stopwatch;
  for (int frame = -1; frame < repeat ||
                       (frame < repeat * kMostFramesFactor && stopwatch.Seconds() < kFramesSeconds);
       ++frame) {
    on_step("frame " + std::to_string(frame + 1));
    RayBuffer rays = MakeFrame(kind, side);
    if (rays.rays().empty()) return std::nullopt;
    result.rays = rays.rays().size();
    // Commit and stream follow each other, as in a program.
    const auto run = [&](Entrant& entrant, Delivery delivery, FrameTimes& times) {
      // As many as hit something, which are not always the same.
      const bool is_whole = delivery.slice == delivery.batch;
      delivery.batch = result.rays;
      delivery.slice = is_whole ? result.rays : std::min(delivery.slice, result.rays);
      Recommit(entrant);
      const double seconds = Deliver(entrant.scene, kind.query, delivery, rays);
      if (frame < 0) return;
      times.commit.push_back(entrant.scene.commit_seconds());
      times.stream.push_back(seconds);
    };
    for (Candidate& finalist : finalists) {
      run(*finalist.entrant, finalist.delivery, finalist.times);
    }
    const HitShares hits(kind.query, rays);
    run(drop_in_, {kIncoherentStream, result.rays, result.rays, 1}, result.dacrt);
    hits.Check(rays);
    result.equal_hits = hits.Equal(rays);
  }
  const Candidate& best = *std::ranges::min_element(
      finalists, {}, [](const Candidate& candidate) { return candidate.times.Frame(); });
  result.embree = best.times;
  result.embree_best = best.entrant->name + " " + Name(best.delivery.call);
  return result;
}

}  // namespace dacrt::bench
