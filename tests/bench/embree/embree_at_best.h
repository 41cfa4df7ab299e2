// Embree, used in the fastest of the ways that there are.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "batch_size.h"
#include "delivery.h"

namespace dacrt::bench {

/// A way to use Embree.
struct EmbreeVariant {
  std::string isa;
  Build build;
  Delivery delivery;

  bool operator==(const EmbreeVariant&) const = default;
};

/// As "avx512 medium coherent stream", with the rays of a call where a batch is cut into slices.
std::string Name(const EmbreeVariant& variant);

/// Into how many rays a call to cut a batch, so that this many threads have work.
std::vector<std::size_t> SliceSizes(std::size_t batch, int threads);

/// Some tens of thousands of rays from the middle, in full packets: enough to tell ways apart.
RayBuffer HeatRays(const RayBuffer& rays);

/// How single rays and packets are sent from this many threads, which take runs of them.
Delivery DeliveryOfCalls(const Call& call, std::size_t batch, int threads);

/// Embree on one scene, on a number of threads: a scene is kept for each instruction set and
/// builder. Scenes of high quality are there to be measured beside the best, not as one of them:
/// few programs wait for them.
class EmbreeAtBest {
 public:
  /// `path` is that of Embree's library; `content` must outlive this. `isa` is the most that Embree
  /// may use. `anew` says that scenes will be committed anew, so that what this costs counts, too.
  EmbreeAtBest(const std::string& path, const SceneContent& content, const std::string& isa,
               int threads, std::span<const Build> builds, bool anew);

  struct Best {
    EmbreeVariant one_shot;  ///< commit and the first batch take the least, where this counts
    EmbreeVariant steady;    ///< the batches of a still scene do
  };

  /// Tries every variant on some tens of thousands of rays from the middle of `rays`, then the two
  /// best for each use on all of them, which then hold Embree's hits. `batch` is size.RaysOfBatch
  /// of the picture, `run` its RaysOfRun.
  Best Find(Query query, const BatchSize& size, std::size_t batch, std::size_t run,
            RayBuffer& rays) const;

  const EmbreeLibrary& Library(const EmbreeVariant& variant) const;
  const CommittedScene& StillScene(const EmbreeVariant& variant) const;

 private:
  struct Still {
    Still(const std::string& isa, Build build, const EmbreeLibrary& library,
          const SceneContent& content, bool anew);

    std::string isa;
    Build build;
    const EmbreeLibrary& library;
    CommittedScene scene;
    double commit_seconds;  ///< the less of two
  };
  struct Trial;

  const Still& Find(const EmbreeVariant& variant) const;
  /// With batches of so many rays; where `batch` is not that of the size, each call has its rays.
  std::vector<EmbreeVariant> Variants(Query query, const BatchSize& size, std::size_t batch) const;
  Trial Try(const EmbreeVariant& variant, Query query, RayBuffer& rays) const;

  int threads_;
  bool anew_;
  std::deque<EmbreeLibrary> libraries_;
  std::deque<Still> stills_;
};

}  // namespace dacrt::bench
