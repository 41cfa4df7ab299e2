// Embree, used in the fastest of the ways that there are.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "delivery.h"

namespace dacrt::bench {

/// A way to use Embree.
struct EmbreeVariant {
  std::string isa;
  RTCBuildQuality quality;
  Delivery delivery;

  bool operator==(const EmbreeVariant&) const = default;
};

/// As "avx512 medium coherent stream", with the rays of a call where a batch is cut into slices.
std::string Name(const EmbreeVariant& variant);

/// Into how many rays a call to cut a batch, so that this many threads have work.
std::vector<std::size_t> SliceSizes(std::size_t batch, int threads);

/// Embree on one scene, on a number of threads: a scene is kept for each instruction set and build
/// quality.
class EmbreeAtBest {
 public:
  /// `scene` must outlive this.
  EmbreeAtBest(const BenchScene& scene, int threads);

  struct Best {
    EmbreeVariant one_shot;  ///< commit and the first batch take the least
    EmbreeVariant steady;    ///< the batches of a still scene do
  };

  /// Tries every variant on some tens of thousands of rays from the middle of `rays`, then the two
  /// best for each use on all of them.
  Best Find(Query query, std::size_t batch, RayBuffer& rays) const;

  const EmbreeLibrary& Library(const EmbreeVariant& variant) const;
  const CommittedScene& StillScene(const EmbreeVariant& variant) const;

 private:
  struct Still {
    Still(const std::string& isa, RTCBuildQuality quality, const EmbreeLibrary& library,
          const BenchScene& mesh)
        : isa(isa),
          quality(quality),
          library(library),
          first_commit_seconds(CommittedScene(library, mesh, quality).commit_seconds()),
          scene(library, mesh, quality) {}

    // Of two: one alone may have been disturbed, and the very first also starts the threads.
    double LeastCommitSeconds() const {
      return std::min(first_commit_seconds, scene.commit_seconds());
    }

    std::string isa;
    RTCBuildQuality quality;
    const EmbreeLibrary& library;
    double first_commit_seconds;
    CommittedScene scene;
  };
  struct Trial;

  const Still& Find(const EmbreeVariant& variant) const;
  std::vector<EmbreeVariant> Variants(Query query, std::size_t batch) const;
  Trial Try(const EmbreeVariant& variant, Query query, RayBuffer& rays) const;

  int threads_;
  std::deque<EmbreeLibrary> libraries_;
  std::deque<Still> stills_;
};

}  // namespace dacrt::bench
