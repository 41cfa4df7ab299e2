// What the filter functions of a scene have answered of late, which says when to ask them.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "trace/stack_slot.h"

namespace dacrt {

class FilterAnswers {
 public:
  /// Those that the caller's thread has seen from the functions of a scene, told by the edition of
  /// its partition (see KeptPartition::edition). It may forget them.
  static FilterAnswers& Of(uint32_t edition) {
    FilterAnswers& answers = all_[SlotOfThisStack() * kScenes + edition % kScenes];
    if (answers.Load().edition != edition) answers.Store({edition, 0, 0});
    return answers;
  }

  /// Whether next to all hits that are shown are accepted.
  bool AcceptMost() const {
    const Seen seen = Load();
    return seen.shown >= kFewest && kShownARejected * seen.rejected <= seen.shown;
  }

  void Count(std::size_t shown, std::size_t accepted) {
    Seen seen = Load();
    seen.shown += static_cast<uint32_t>(shown);
    seen.rejected += static_cast<uint32_t>(shown - accepted);
    // What was long ago is forgotten.
    if (seen.shown >= kMost) {
      seen.shown /= 2;
      seen.rejected /= 2;
    }
    Store(seen);
  }

 private:
  static constexpr uint32_t kFewest = 64, kMost = 1024, kShownARejected = 32;
  static constexpr std::size_t kScenes = 8;  ///< that a thread traces in turn: a cache line

  struct Seen {
    uint32_t edition, shown, rejected;
  };
  Seen Load() const {
    const uint64_t bits = seen_.load(std::memory_order_relaxed);
    return {static_cast<uint32_t>(bits >> 32), static_cast<uint32_t>(bits >> 16) & 0xFFFF,
            static_cast<uint32_t>(bits) & 0xFFFF};
  }
  void Store(const Seen& seen) {
    // In one word, because threads may share it.
    seen_.store(uint64_t{seen.edition} << 32 | seen.shown << 16 | seen.rejected,
                std::memory_order_relaxed);
  }

  using All = std::array<FilterAnswers, kStackSlots * kScenes>;
  alignas(64) static All all_;

  std::atomic<uint64_t> seen_{0};
};

alignas(64) inline constinit FilterAnswers::All FilterAnswers::all_{};

}  // namespace dacrt
