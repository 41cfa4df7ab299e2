// The leaf in which a ray that looks for any hit was blocked last: where the next one is blocked,
// too, it is so there more often than not, and needs no nodes to find that out. What blocks a ray
// makes no difference to the answer.
//
// Pearce, Jevans, "Exploiting shadow coherence in ray tracing", Graphics Interface '91.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "geometry/wide_node.h"
#include "trace/stack_slot.h"

namespace dacrt {

class alignas(64) LastBlocker {
 public:
  /// That of the caller's thread.
  static LastBlocker& OfThisStack() { return all_[SlotOfThisStack()]; }

  /// The leaf, if it was one of a partition that still is what it was then (see
  /// KeptPartition::edition).
  std::optional<ChildWord> In(uint32_t edition) const {
    const uint64_t last = last_.load(std::memory_order_relaxed);
    if (last >> 32 != edition) return std::nullopt;
    return ChildWord(static_cast<uint32_t>(last));
  }

  void Remember(uint32_t edition, ChildWord leaf) {
    // In one word: threads that share it must not see the edition of one and the leaf of another.
    last_.store(uint64_t{edition} << 32 | leaf.bits(), std::memory_order_relaxed);
  }
  void Forget() { last_.store(0, std::memory_order_relaxed); }

 private:
  static std::array<LastBlocker, kStackSlots> all_;

  std::atomic<uint64_t> last_{0};
};

inline constinit std::array<LastBlocker, kStackSlots> LastBlocker::all_{};

}  // namespace dacrt
