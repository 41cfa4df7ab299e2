// Nodes of least surface over leaves that are there already: of those a subset has a fifth or a
// sixth as many as triangles.

#if defined(DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
#undef DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
#else
#define DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
#endif

#include <span>

#include "partition/build_nodes-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A leaf as what is split: bounds, and the bits of its ChildWord in the place of a name.
inline TriangleRef ReferLeaf(const Extent& bounds, ChildWord word) {
  TriangleRef leaf;
  bounds.Put(leaf);
  leaf.primitive = word.bits();
  leaf.geometry = 0;
  return leaf;
}

/// A sixth of the ranges is tried, once: four fifths of what trying all of them gains, in a fifth
/// of the time, 8 to 16 ns a triangle.
constexpr ReinsertionEffort kOverLeaves{1, 1};

/// Makes nodes in scratch.nodes over `leaves`, which are ordered anew, the root first. Returns how
/// many there are, 0 if they have no room.
inline size_t MakeNodesOver(std::span<TriangleRef> leaves, SubsetScratch& scratch) {
  struct Whole {
    HWY_INLINE size_t Weight(const TriangleRef&) const { return kLeafLanes; }
  };
  struct Words {
    bool IsLeaf(const WeighedRange& child) const { return child.range.count() == 1; }
    ChildWord Child(const BinaryRange& child) { return ChildWord(leaves[child.begin].primitive); }
    std::span<const TriangleRef> leaves;
  } words{leaves};
  const TriangleRange all = MeasureTriangles(leaves.data(), 0, leaves.size());
  return NodeBuilder(Whole(), kOverLeaves, leaves.data(), words, std::span(scratch.ranges),
                     std::span(scratch.nodes), scratch)
      .Build({all, leaves.size() * kLeafLanes});
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_NODES_OVER_LEAVES_INL_H_
