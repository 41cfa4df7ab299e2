// Which child a ray took last at a node, as a guess where the next one goes: rays of neighbouring
// pixels go the same way. A processor that foresees that the guess is right is at the next node
// long before it knows so from the distances; what is found does not depend on it.
//
// Lipasti, Wilkerson, Shen, "Value locality and load value prediction", ASPLOS 1996, by a branch.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "geometry/wide_node.h"
#include "trace/stack_slot.h"

namespace dacrt {

/// The same word, of which no compiler knows: the branch that leads here stays one.
inline ChildWord ByBranch(ChildWord word) {
  uint32_t bits = word.bits();
  asm volatile("" : "+r"(bits));
  return ChildWord(bits);
}

class alignas(64) ChildGuesses {
 public:
  /// Those of the caller's thread.
  static ChildGuesses& OfThisStack() { return all_[SlotOfThisStack()]; }

  /// The child `taken` of a node, which the next ray is guessed to take.
  ChildWord Take(uint32_t node, ChildWord taken) {
    // Numbers of exact nodes are even.
    std::atomic<uint32_t>& last = last_[(node ^ node / kNodes) % kNodes];
    const ChildWord guess(last.load(std::memory_order_relaxed));
    // A compiler that knew that both are the same could go on with the one that comes late.
    if (taken.bits() == ByBranch(guess).bits()) return ByBranch(guess);
    last.store(taken.bits(), std::memory_order_relaxed);
    return taken;
  }

 private:
  static constexpr std::size_t kNodes = 256;

  static std::array<ChildGuesses, kStackSlots> all_;

  std::array<std::atomic<uint32_t>, kNodes> last_{};
};

inline constinit std::array<ChildGuesses, kStackSlots> ChildGuesses::all_{};

}  // namespace dacrt
