#include "embree_contest.h"

#include <algorithm>
#include <limits>

#include "errors.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

constexpr char kThreads[] = "threads=1";
// What the drop-in is called with: it finds out itself how coherent the rays are.
constexpr Call kDropInCall = Call::kIncoherentStream;

const char* Name(RTCBuildQuality quality) {
  return quality == RTC_BUILD_QUALITY_LOW ? "low" : "medium";
}

// Embree's 16-wide coherent occlusion is known not to return on some scenes; AVX2 stands in for it.
bool IsUsable(const EmbreeVariant& variant, Query query) {
  return !(variant.isa == "avx512" && variant.call == Call::kCoherentStream &&
           query == Query::kAny);
}

std::size_t CountHits(Query query, const RayBuffer& rays) {
  return std::ranges::count_if(rays.rays(), [query](const RayRecord& ray) {
    return query == Query::kAny ? ray.tfar < 0 : ray.geometry_id != kNoGeometry;
  });
}

double Timed(const CommittedScene& scene, Query query, Call call, RayBuffer& rays) {
  rays.Rearm();
  return scene.Trace(query, call, rays);
}

void CheckHits(std::size_t embree, std::size_t dacrt, std::size_t rays) {
  constexpr double kTolerance = 1e-4;  // of the rays: edges and ends decided the other way
  const double apart = embree > dacrt ? embree - dacrt : dacrt - embree;
  if (apart <= kTolerance * rays + 1) return;
  throw Disagreement("Embree finds " + std::to_string(embree) + " hits and dacrt " +
                     std::to_string(dacrt) + " with the same " + std::to_string(rays) + " rays");
}

}  // namespace

std::string Name(const EmbreeVariant& variant) {
  return variant.isa + ", " + Name(variant.quality) + ", " + Name(variant.call);
}

double Times::OneShot() const {
  std::vector<double> sums;
  for (std::size_t i = 0; i < commit.size(); ++i) sums.push_back(commit[i] + first[i]);
  return Median(sums);
}

double EmbreeResult::OneShotRatio() const { return embree.OneShot() / dacrt.OneShot(); }

double EmbreeResult::SteadyRatio() const { return Median(embree.steady) / Median(dacrt.steady); }

std::vector<RayKind> RayKinds() {
  return {
      {"primary", Query::kClosest, nullptr},
      {"shadow", Query::kAny,
       [](const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
         generation.MakeOcclusionRays(Occlusion::kPointLight, 0, hits, rays);
       }},
      {"ambient", Query::kAny,
       [](const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
         generation.MakeOcclusionRays(Occlusion::kAmbient, 0, hits, rays);
       }},
      {"diffuse", Query::kClosest,
       [](const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
         generation.Continue(Scatter::kDiffuse, 0, hits, rays);
       }},
  };
}

struct EmbreeContest::Best {
  EmbreeVariant one_shot, steady;
};

EmbreeContest::EmbreeContest() : drop_in_(DACRT_DROP_IN, kThreads) {
  for (const char* const isa : {"avx2", "avx512"}) {
    embrees_.push_back(
        {isa, EmbreeLibrary(DACRT_REAL_EMBREE, std::string(kThreads) + ",isa=" + isa)});
  }
}

const EmbreeLibrary& EmbreeContest::Library(const EmbreeVariant& variant) const {
  return std::ranges::find(embrees_, variant.isa, &Embree::isa)->library;
}

EmbreeContest::Best EmbreeContest::FindBest(const BenchScene& scene, Query query,
                                            RayBuffer& rays) const {
  Best best;
  double least_one_shot = std::numeric_limits<double>::infinity();
  double least_steady = least_one_shot;
  for (const Embree& embree : embrees_) {
    for (const RTCBuildQuality quality : {RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM}) {
      const CommittedScene committed(embree.library, scene, quality);
      for (const Call call : {Call::kCoherentStream, Call::kIncoherentStream, Call::kSingleRays}) {
        const EmbreeVariant variant{embree.isa, quality, call};
        if (!IsUsable(variant, query)) continue;
        const double seconds = Timed(committed, query, call, rays);
        if (seconds < least_steady) {
          least_steady = seconds;
          best.steady = variant;
        }
        if (committed.commit_seconds() + seconds < least_one_shot) {
          least_one_shot = committed.commit_seconds() + seconds;
          best.one_shot = variant;
        }
      }
    }
  }
  return best;
}

EmbreeResult EmbreeContest::Measure(const BenchScene& scene, const RayKind& kind,
                                    const Raster& raster, int repeat, const OnStep& on_step) const {
  on_step("making rays");
  const CommittedScene still_dacrt(drop_in_, scene, RTC_BUILD_QUALITY_MEDIUM);
  const RayGeneration generation(scene);
  RayBuffer primary(raster.RayCount());
  RayBuffer derived(kind.make ? raster.RayCount() : 0);
  generation.MakeCameraRays(raster, false, primary);
  if (kind.make) {
    still_dacrt.Trace(Query::kClosest, kDropInCall, primary);
    kind.make(generation, primary, derived);
  }
  RayBuffer& rays = kind.make ? derived : primary;

  on_step("looking for Embree's best");
  const Best best = FindBest(scene, kind.query, rays);
  const CommittedScene still_embree(Library(best.steady), scene, best.steady.quality);
  Timed(still_embree, kind.query, best.steady.call, rays);
  const std::size_t embree_hits = CountHits(kind.query, rays);
  Timed(still_dacrt, kind.query, kDropInCall, rays);
  CheckHits(embree_hits, CountHits(kind.query, rays), rays.rays().size());

  EmbreeResult result{scene.name,    scene.TriangleCount(), kind.name, rays.rays().size(),
                      best.one_shot, best.steady,           {},        {}};
  const auto one_shot = [&](const EmbreeLibrary& library, RTCBuildQuality quality, Call call,
                            Times& times) {
    const CommittedScene fresh(library, scene, quality);
    times.commit.push_back(fresh.commit_seconds());
    times.first.push_back(Timed(fresh, kind.query, call, rays));
  };
  for (int round = 0; round < repeat; ++round) {
    on_step("round " + std::to_string(round + 1) + " of " + std::to_string(repeat));
    one_shot(Library(best.one_shot), best.one_shot.quality, best.one_shot.call, result.embree);
    one_shot(drop_in_, RTC_BUILD_QUALITY_MEDIUM, kDropInCall, result.dacrt);
    result.embree.steady.push_back(Timed(still_embree, kind.query, best.steady.call, rays));
    result.dacrt.steady.push_back(Timed(still_dacrt, kind.query, kDropInCall, rays));
  }
  return result;
}

}  // namespace dacrt::bench
