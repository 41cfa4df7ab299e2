// A node of the kept partition: up to eight child volumes, in the order in which rays that look for
// any hit visit them.
//
// Where there is memory enough the faces of the volumes are stored as they are, and a node is four
// cache lines; else in eight bits a face, relative to the node's own box, and it is two; Ylitie,
// Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", HPG
// 2017. A volume is never smaller than what it holds, so rounding costs tests and changes no hit:
// in a room most rays begin at a wall, whose volume is flat, and which they then enter.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

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

  /// Of an exact node; the second one has no name of its own.
  static constexpr std::size_t kExactSlots = 2;

  uint32_t child[kWidth];  ///< bits of a ChildWord each
  uint32_t lock;           ///< of the leaves; see TryLockLeaves
  uint8_t count;           ///< children
  uint8_t bare;            ///< a bit a child; see BareLeaves
  uint8_t marks;           ///< the same; see StaleLeaves and UnvisitedLeaves
  bool is_exact;           ///< faces are stored as they are, see ExactFaces
  float origin[3];         ///< of a node that is not exact, as what follows
  float scale[3];          ///< the size of a step, a number of eight bits
  uint8_t lower[3][kWidth];
  uint8_t upper[3][kWidth];

  /// So many nodes that are not exact have its place in memory: numbers count them.
  uint32_t slots() const { return is_exact ? kExactSlots : 1; }

  /// Of an exact node: those that bound its children from below, axis by axis, and those from
  /// above, in the place of `lower` and in the slot behind.
  const float* ExactFaces() const {
    DACRT_ASSERT(is_exact);
    return reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(this) + kFaces);
  }
  float* ExactFaces() { return const_cast<float*>(std::as_const(*this).ExactFaces()); }

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

  /// Those of some children that are leaves without a copy of their geometry, or with one that the
  /// triangles have moved away from.
  uint32_t BareLeaves(uint32_t children) const {
    return children & std::atomic_ref(const_cast<uint8_t&>(bare)).load(kAcquire);
  }
  /// Of these, those whose copy is wrong: it must not be read before it is renewed.
  uint32_t StaleLeaves(uint32_t children) const {
    return MarkedLeaves(children, [](ChildWord leaf) { return leaf.IsBlock(); });
  }
  /// Of these, those without a copy that are to have none before rays come a second time.
  uint32_t UnvisitedLeaves(uint32_t children) const {
    return MarkedLeaves(children, [](ChildWord leaf) { return leaf.IsRange(); });
  }
  /// Says that rays have come to them.
  void SetLeavesVisited(uint32_t children) {
    std::atomic_ref(marks).fetch_and(static_cast<uint8_t>(~children), kRelease);
  }
  /// Says that no rays have come to any. Nobody may trace meanwhile.
  void SetLeavesUnvisited() { marks = bare; }
  /// True for the one thread that may give leaves their geometry, until it calls UnlockLeaves.
  bool TryLockLeaves() { return std::atomic_ref(lock).exchange(1, std::memory_order_acquire) == 0; }
  void UnlockLeaves() {
    const std::atomic_ref word(lock);
    word.store(0, kRelease);
    word.notify_all();
  }
  /// Returns when another thread is done with the leaves.
  void WaitForLeaves() { std::atomic_ref(lock).wait(1, kAcquire); }
  /// Says that children have their geometry, or will never have it.
  void SetLeavesDone(uint32_t children = UINT8_MAX) {
    const auto others = static_cast<uint8_t>(~children);
    std::atomic_ref(marks).fetch_and(others, kRelease);
    std::atomic_ref(bare).fetch_and(others, kRelease);
  }
  /// Says that leaves without a copy may get one.
  void SetLeavesBare() {
    uint8_t children = 0;
    for (std::size_t i = 0; i < count; ++i) {
      children |= static_cast<uint8_t>(Child(i).IsRange() << i);
    }
    std::atomic_ref(bare).fetch_or(children, kRelease);
  }
  /// A child's triangles have moved: its copy is wrong. Nobody may trace meanwhile.
  void SetLeafStale(std::size_t i) {
    DACRT_ASSERT(ChildWord(child[i]).IsBlock());
    bare |= static_cast<uint8_t>(1u << i);
    marks |= static_cast<uint8_t>(1u << i);
  }

  uint32_t UsedChildren() const { return (1u << count) - 1; }

 private:
  template <class Is>
  uint32_t MarkedLeaves(uint32_t children, const Is& is) const {
    const uint32_t marked = children & std::atomic_ref(const_cast<uint8_t&>(marks)).load(kAcquire);
    uint32_t leaves = 0;
    for (uint32_t left = marked; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      leaves |= static_cast<uint32_t>(is(Child(i))) << i;
    }
    return leaves;
  }

  static constexpr std::size_t kFaces = 64;
  static constexpr auto kAcquire = std::memory_order_acquire;
  static constexpr auto kRelease = std::memory_order_release;
};
static_assert(sizeof(WideNode) == 128 && offsetof(WideNode, lower) == 64);

/// An exact node with the place for it.
struct ExactNode : WideNode {
  std::byte rest[(kExactSlots - 1) * sizeof(WideNode)];
};
static_assert(sizeof(ExactNode) == WideNode::kExactSlots * sizeof(WideNode));

/// Some in a row; numbers count slots.
inline constexpr ChildWord InnerOfExact(std::size_t i) {
  return ChildWord::Inner(static_cast<uint32_t>(WideNode::kExactSlots * i));
}

}  // namespace dacrt
