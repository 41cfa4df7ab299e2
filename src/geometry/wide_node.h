// A node of the kept partition: up to eight child volumes in two cache lines.
//
// The volumes are stored in eight bits a face, relative to the node's own box; Ylitie, Karras,
// Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", HPG 2017. A
// volume is never smaller than what it holds, so rounding costs tests and changes no hit.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "runtime/assert.h"

namespace dacrt {

/// What stands behind a child volume, in one word: what it is, and its number or place.
///
///   inner   a node, by its number
///   subset  triangles that may not be split yet, by the number of the subset
///   block   a leaf that carries its geometry (leaf/leaf_block.h), by its place in the leaf memory
///   range   a leaf that does not: triangles of the kept order, from the place on to the first one
///           that is marked as the last of its leaf
class ChildWord {
 public:
  static constexpr uint32_t kMostNumber = (1u << 29) - 1;
  static constexpr uint32_t kMostBlock = (1u << 30) - 1;
  static constexpr uint32_t kMostRange = (1u << 31) - 1;

  static constexpr ChildWord Inner(uint32_t number) {
    DACRT_ASSERT(number <= kMostNumber);
    return ChildWord(number);
  }
  static constexpr ChildWord Subset(uint32_t number) {
    DACRT_ASSERT(number <= kMostNumber);
    return ChildWord(kSubset | number);
  }
  static constexpr ChildWord Block(uint32_t place) {
    DACRT_ASSERT(place <= kMostBlock);
    return ChildWord(kBlock | place);
  }
  static constexpr ChildWord Range(uint32_t place) {
    DACRT_ASSERT(place <= kMostRange);
    return ChildWord(kRange | place);
  }

  constexpr ChildWord() = default;
  constexpr explicit ChildWord(uint32_t bits) : bits_(bits) {}

  constexpr uint32_t bits() const { return bits_; }
  constexpr bool IsInner() const { return bits_ < kSubset; }
  constexpr bool IsSubset() const { return bits_ >= kSubset && bits_ < kBlock; }
  constexpr bool IsBlock() const { return bits_ >= kBlock && bits_ < kRange; }
  constexpr bool IsRange() const { return bits_ >= kRange; }
  constexpr bool IsLeaf() const { return bits_ >= kBlock; }

  constexpr uint32_t number() const { return bits_ & kMostNumber; }
  constexpr uint32_t block() const { return bits_ & kMostBlock; }
  constexpr uint32_t range() const { return bits_ & kMostRange; }

 private:
  static constexpr uint32_t kSubset = 1u << 29;
  static constexpr uint32_t kBlock = 1u << 30;
  static constexpr uint32_t kRange = 1u << 31;

  uint32_t bits_ = 0;
};

struct alignas(64) WideNode {
  static constexpr std::size_t kWidth = 8;

  float origin[3];
  uint16_t scale[3];  ///< upper half of a float: the size of a step
  uint8_t count;      ///< children
  uint8_t visits;     ///< while leaves do not carry their geometry; see CountVisit
  uint8_t lower[3][kWidth];
  uint8_t upper[3][kWidth];
  uint32_t child[kWidth];  ///< bits of a ChildWord each

  /// What other threads may change meanwhile: a child from a subset to its node, or from a range to
  /// a block. Old and new say the same.
  ChildWord Child(std::size_t i) const {
    DACRT_ASSERT(i < count);
    return ChildWord(std::atomic_ref(const_cast<uint32_t&>(child[i])).load(kAcquire));
  }
  void SetChild(std::size_t i, ChildWord word) {
    DACRT_ASSERT(i < count);
    std::atomic_ref(child[i]).store(word.bits(), kRelease);
  }

  /// Whether leaves have yet to be given their geometry.
  bool HasBareLeaves() const {
    return std::atomic_ref(const_cast<uint8_t&>(visits)).load(std::memory_order_relaxed) != kDone;
  }
  /// Returns the visits so far. Threads may lose each other's visits, but never a claim: a plain
  /// store here could undo one.
  uint8_t CountVisit() {
    const std::atomic_ref counter(visits);
    const uint8_t before = counter.load(std::memory_order_relaxed);
    if (before < kBusy - 1) {
      uint8_t expected = before;
      counter.compare_exchange_strong(expected, before + 1, std::memory_order_relaxed);
    }
    return before;
  }
  /// True for the one thread that is to give the leaves their geometry.
  bool ClaimLeaves() {
    const std::atomic_ref counter(visits);
    uint8_t before = counter.load(std::memory_order_relaxed);
    while (before < kBusy) {
      if (counter.compare_exchange_weak(before, kBusy)) return true;
    }
    return false;
  }
  void SetLeavesDone() { std::atomic_ref(visits).store(kDone, std::memory_order_relaxed); }

  uint32_t UsedChildren() const { return (1u << count) - 1; }

 private:
  static constexpr uint8_t kBusy = 254;
  static constexpr uint8_t kDone = 255;
  static constexpr auto kAcquire = std::memory_order_acquire;
  static constexpr auto kRelease = std::memory_order_release;
};
static_assert(sizeof(WideNode) == 128);

}  // namespace dacrt
