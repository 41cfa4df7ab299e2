#include "embree_at_best.h"

#include <algorithm>
#include <span>

#include "isa.h"

namespace dacrt::bench {
namespace {

// More only where it is between the best.
constexpr std::size_t kHeatRays = 32'768;
constexpr std::size_t kFinalists = 2;

// Embree's 16-wide coherent occlusion is known not to return on some scenes; AVX2 stands in for it.
bool IsUsable(const std::string& isa, const Call& call, Query query) {
  return !(isa == "avx512" && call.is_coherent && query == Query::kAny);
}

}  // namespace

std::string Name(const EmbreeVariant& variant) {
  const Delivery& delivery = variant.delivery;
  std::string name = variant.isa + " " + Name(variant.build) + " " + Name(delivery.call);
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

RayBuffer HeatRays(const RayBuffer& rays) {
  constexpr std::size_t kMostPacket = 16;
  const std::size_t all = rays.rays().size();
  const std::size_t count = std::min(all, kHeatRays);
  return rays.Part((all - count) / 2 / kMostPacket * kMostPacket, count);
}

Delivery DeliveryOfCalls(const Call& call, std::size_t batch, int threads) {
  constexpr std::size_t kRun = 1024;  // rays: long enough to take, short enough to wait for
  return {call, batch, threads == 1 ? batch : std::min(kRun, batch), threads};
}

struct EmbreeAtBest::Trial {
  EmbreeVariant variant;
  double one_shot;
  double steady;
};

// Of two commits one alone may have been disturbed, and the very first also starts the threads.
EmbreeAtBest::Still::Still(const std::string& isa, Build build, const EmbreeLibrary& library,
                           const SceneContent& content, bool anew)
    : isa(isa),
      build(build),
      library(library),
      scene(library, content, build),
      commit_seconds(scene.commit_seconds()) {
  if (!anew) return;
  commit_seconds =
      std::min(commit_seconds, CommittedScene(library, content, build).commit_seconds());
}

EmbreeAtBest::EmbreeAtBest(const std::string& path, const SceneContent& content,
                           const std::string& isa, int threads, std::span<const Build> builds,
                           bool anew)
    : threads_(threads), anew_(anew) {
  for (const std::string& tried : IsasWithin(isa)) {
    const EmbreeLibrary& library = libraries_.emplace_back(path, DeviceConfig(tried, threads));
    for (const Build build : builds) {
      // What a commit of high quality costs counts nowhere.
      stills_.emplace_back(tried, build, library, content, anew && build != Build::kHigh);
    }
  }
}

EmbreeAtBest::Best EmbreeAtBest::Find(Query query, const BatchSize& size, std::size_t batch,
                                      std::size_t run, RayBuffer& rays) const {
  RayBuffer heat_rays = HeatRays(rays);
  const auto trials_of = [&](std::size_t together) {
    std::vector<Trial> trials;
    for (const EmbreeVariant& variant : Variants(query, size, together)) {
      trials.push_back(Try(variant, query, heat_rays));
    }
    return trials;
  };
  std::vector<Trial> trials = trials_of(run);
  const auto best = [&](double Trial::*time) {
    std::ranges::sort(trials, {}, time);
    std::vector<Trial> finals;
    for (const Trial& trial : std::span(trials).first(std::min(kFinalists, trials.size()))) {
      finals.push_back(Try(trial.variant, query, rays));
    }
    return std::ranges::min_element(finals, {}, time)->variant;
  };
  const EmbreeVariant steady = best(&Trial::steady);
  if (!anew_) return {steady, steady};
  if (batch != run) trials = trials_of(batch);
  return {best(&Trial::one_shot), steady};
}

const EmbreeLibrary& EmbreeAtBest::Library(const EmbreeVariant& variant) const {
  return Find(variant).library;
}

const CommittedScene& EmbreeAtBest::StillScene(const EmbreeVariant& variant) const {
  return Find(variant).scene;
}

const EmbreeAtBest::Still& EmbreeAtBest::Find(const EmbreeVariant& variant) const {
  return *std::ranges::find_if(stills_, [&](const Still& still) {
    return still.isa == variant.isa && still.build == variant.build;
  });
}

std::vector<EmbreeVariant> EmbreeAtBest::Variants(Query query, const BatchSize& size,
                                                  std::size_t batch) const {
  std::vector<EmbreeVariant> variants;
  for (const Still& still : stills_) {
    if (still.build == Build::kHigh) continue;
    for (const Call& call : size.Calls()) {
      if (!IsUsable(still.isa, call, query)) continue;
      if (!size.IsStream()) {
        variants.push_back({still.isa, still.build, DeliveryOfCalls(call, batch, threads_)});
        continue;
      }
      const bool is_run = batch != size.RaysOfBatch(batch);
      for (const std::size_t slice :
           is_run ? std::vector{size.rays} : SliceSizes(batch, threads_)) {
        variants.push_back({still.isa, still.build, {call, batch, slice, threads_}});
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
  return {variant, still.commit_seconds + of_batch, of_batch};
}

}  // namespace dacrt::bench
