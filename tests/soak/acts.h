// What the threads of a soak do: each act compares every answer with one that was, or is, got
// otherwise.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "embree_scene.h"
#include "player.h"
#include "world.h"

namespace dacrt::tests {

class Acts {
 public:
  enum Kind {
    kAskStanding,   ///< scenes that all threads ask, by any call
    kPlayWorld,     ///< a world with its changes, on the common device and on one of its own
    kSplitAnew,     ///< a scene of many triangles, committed and asked at once by this thread and
                    ///< others
    kRefuseMemory,  ///< a world where the memory monitor refuses
    kChurn,         ///< handles of all kinds made and released, wrong calls between them
    kKindCount
  };

  /// Makes the standing scenes and their answers.
  explicit Acts(uint64_t seed);
  ~Acts();

  /// One act, chosen by the seed. From any thread. Throws std::runtime_error that says what is
  /// wrong.
  void Act(uint64_t seed) const;

  std::size_t Count(Kind kind) const { return counts_[kind]; }
  std::size_t refusals() const { return refusals_; }  ///< calls that failed for want of memory
  std::size_t rays() const { return rays_; }          ///< whose answers were compared

 private:
  struct Standing;
  void AskStanding(uint64_t seed) const;
  void PlayWorld(uint64_t seed) const;
  void SplitAnew(uint64_t seed) const;
  void RefuseMemory(uint64_t seed) const;
  void Churn(uint64_t seed) const;
  void Compare(const char* act, uint64_t seed, std::span<const RTCRayHit> expected,
               std::span<const RTCRayHit> answers) const;

  EmbreeDevice common_;
  std::vector<std::unique_ptr<Standing>> standing_;
  mutable std::array<std::atomic<std::size_t>, kKindCount> counts_{};
  mutable std::atomic<std::size_t> refusals_{0}, rays_{0};
};

}  // namespace dacrt::tests
