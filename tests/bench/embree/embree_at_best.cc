#include "embree_at_best.h"

#include <algorithm>
#include <span>

namespace dacrt::bench {
namespace {

// Enough rays to tell the variants apart; more only where it is between the best.
constexpr std::size_t kHeatRays = 65'536;
constexpr std::size_t kFinalists = 2;

// Embree's 16-wide coherent occlusion is known not to return on some scenes; AVX2 stands in for it.
bool IsUsable(const std::string& isa, Call call, Query query) {
  return !(isa == "avx512" && call == Call::kCoherentStream && query == Query::kAny);
}

const char* Name(RTCBuildQuality quality) {
  return quality == RTC_BUILD_QUALITY_LOW ? "low" : "medium";
}

RayBuffer HeatRays(const RayBuffer& rays) {
  const std::size_t all = rays.rays().size();
  const std::size_t count = std::min(all, kHeatRays);
  return rays.Part((all - count) / 2, count);
}

}  // namespace

std::string Name(const EmbreeVariant& variant) {
  const Delivery& delivery = variant.delivery;
  std::string name = variant.isa + " " + Name(variant.quality) + " " + Name(delivery.call);
  if (delivery.slice < delivery.batch) name += " / " + std::to_string(delivery.slice);
  return name;
}

std::vector<std::size_t> SliceSizes(std::size_t batch, int threads) {
  // Of these a large batch has many for each thread, so that none waits long for the last.
  constexpr std::size_t kSlices[] = {1024, 8192};
  if (threads == 1) return {batch};
  if (batch >= 2 * kSlices[1] * threads) return {std::begin(kSlices), std::end(kSlices)};
  // A small one is shared out once, or is not worth it.
  return {(batch + threads - 1) / threads, batch};
}

struct EmbreeAtBest::Trial {
  EmbreeVariant variant;
  double one_shot;
  double steady;
};

EmbreeAtBest::EmbreeAtBest(const BenchScene& scene, int threads) : threads_(threads) {
  for (const char* const isa : {"avx2", "avx512"}) {
    const EmbreeLibrary& library = libraries_.emplace_back(
        DACRT_REAL_EMBREE, "threads=" + std::to_string(threads) + ",isa=" + isa);
    for (const RTCBuildQuality quality : {RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM}) {
      stills_.emplace_back(isa, quality, library, scene);
    }
  }
}

EmbreeAtBest::Best EmbreeAtBest::Find(Query query, std::size_t batch, RayBuffer& rays) const {
  RayBuffer heat_rays = HeatRays(rays);
  std::vector<Trial> trials;
  for (const EmbreeVariant& variant : Variants(query, batch)) {
    trials.push_back(Try(variant, query, heat_rays));
  }
  std::vector<Trial> finals;
  for (const auto time : {&Trial::one_shot, &Trial::steady}) {
    std::ranges::sort(trials, {}, time);
    for (const Trial& trial : std::span(trials).first(kFinalists)) {
      if (std::ranges::find(finals, trial.variant, &Trial::variant) != finals.end()) continue;
      finals.push_back(Try(trial.variant, query, rays));
    }
  }
  return {std::ranges::min_element(finals, {}, &Trial::one_shot)->variant,
          std::ranges::min_element(finals, {}, &Trial::steady)->variant};
}

const EmbreeLibrary& EmbreeAtBest::Library(const EmbreeVariant& variant) const {
  return Find(variant).library;
}

const CommittedScene& EmbreeAtBest::StillScene(const EmbreeVariant& variant) const {
  return Find(variant).scene;
}

const EmbreeAtBest::Still& EmbreeAtBest::Find(const EmbreeVariant& variant) const {
  return *std::ranges::find_if(stills_, [&](const Still& still) {
    return still.isa == variant.isa && still.quality == variant.quality;
  });
}

std::vector<EmbreeVariant> EmbreeAtBest::Variants(Query query, std::size_t batch) const {
  std::vector<EmbreeVariant> variants;
  for (const Still& still : stills_) {
    for (const Call call : {Call::kCoherentStream, Call::kIncoherentStream, Call::kSingleRays}) {
      if (!IsUsable(still.isa, call, query)) continue;
      for (const std::size_t slice : SliceSizes(batch, threads_)) {
        variants.push_back({still.isa, still.quality, {call, batch, slice, threads_}});
      }
    }
  }
  return variants;
}

EmbreeAtBest::Trial EmbreeAtBest::Try(const EmbreeVariant& variant, Query query,
                                      RayBuffer& rays) const {
  const Still& still = Find(variant);
  const double seconds = Deliver(still.scene, query, variant.delivery, rays);
  const double of_batch = seconds / rays.rays().size() * variant.delivery.batch;
  return {variant, still.LeastCommitSeconds() + of_batch, of_batch};
}

}  // namespace dacrt::bench
