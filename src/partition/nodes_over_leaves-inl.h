// Nodes of least surface over leaves that there are already: a sixth as many references as there
// are triangles, so that they cost little.

#if defined(DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
#undef DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
#else
#define DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
#endif

#include <limits>
#include <span>

#include "partition/build_nodes-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// References to leaves, in the order of a curve.
struct LeafBoxes {
  HWY_INLINE size_t Weight(const TriangleRef&) const { return kLeafLanes; }
};

/// Ranges of up to so many leaves are split where they stand: they are most of all ranges, and any
/// order of so few is good. With none so, 4, 8 and 16 nodes cost 30, 21, 17 and 17 ns a triangle of
/// Sponza, and rays take the same time within a percent but for the last, where it is a percent
/// more.
constexpr size_t kLeavesInOrder = 8;

/// The best split of a few references that stay where they are, by the surfaces of its sides.
inline WeighedChildren SplitInOrder(const TriangleRef* refs, const WeighedRange& parent) {
  const size_t begin = parent.range.begin, count = parent.range.count();
  DACRT_ASSERT(count >= 2 && count <= kLeavesInOrder);
  float right_cost[kLeavesInOrder];
  Extent side = Extent::Empty();
  for (size_t k = count - 1; k > 0; --k) {
    side.Join(Extent::Of(refs[begin + k]));
    right_cost[k] = side.HalfArea() * static_cast<float>(count - k);
  }
  side = Extent::Empty();
  float best_cost = std::numeric_limits<float>::infinity();
  size_t best = 0, best_larger = SIZE_MAX;
  Extent left = Extent::Empty();
  for (size_t k = 1; k < count; ++k) {
    side.Join(Extent::Of(refs[begin + k - 1]));
    const float cost = side.HalfArea() * static_cast<float>(k) + right_cost[k];
    const size_t larger = HWY_MAX(k, count - k);
    // Volumes that are all flat say nothing: then sides should be even.
    if (cost > best_cost || (cost == best_cost && larger >= best_larger)) continue;
    best_cost = cost;
    best_larger = larger;
    best = k;
    left = side;
  }
  Extent right = Extent::Empty();
  for (size_t k = best; k < count; ++k) right.Join(Extent::Of(refs[begin + k]));
  const size_t middle = begin + best;
  // Where the centres lie nobody will ask.
  return {{{begin, middle, left.Get(), Box::Empty()}, best * kLeafLanes},
          {{middle, parent.range.end, right.Get(), Box::Empty()}, (count - best) * kLeafLanes}};
}

inline WeighedChildren SplitRange(const LeafBoxes& leaves, TriangleRef* refs,
                                  const WeighedRange& parent, SubsetScratch& scratch) {
  if (parent.range.count() <= kLeavesInOrder) return SplitInOrder(refs, parent);
  return SplitRange<LeafBoxes>(leaves, refs, parent, scratch);
}

/// Leaves of which each is referred to by its word.
struct KnownLeaves {
  bool IsLeaf(const WeighedRange& child) const { return child.range.count() == 1; }
  ChildWord Child(const BinaryRange& child) const { return ChildWord(refs[child.begin].primitive); }

  const TriangleRef* refs;
};

template <class Corners>
inline void ReferLeaf(const Corners& bounds, ChildWord word, TriangleRef& ref) {
  std::copy_n(bounds.lower, 3, ref.lower);
  std::copy_n(bounds.upper, 3, ref.upper);
  ref.primitive = word.bits();
  ref.geometry = 0;
}

/// Makes nodes over leaves that are a range of scratch.refs, the root first. Returns how many there
/// are, 0 if they have no room.
inline size_t BuildNodesOver(const TriangleRange& range, SubsetScratch& scratch) {
  KnownLeaves leaves{scratch.refs};
  return NodeBuilder(LeafBoxes(), scratch.refs, leaves, std::span(scratch.ranges),
                     std::span(scratch.nodes), scratch)
      .Build({range, range.count() * kLeafLanes});
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
