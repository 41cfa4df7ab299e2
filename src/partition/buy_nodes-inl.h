// Nodes of least surface over the leaves that a small subset has: bought once its packed ones have
// cost as much (rent_or_buy.h). Leaves stay as they are, and whoever walks the old nodes goes on.

#if defined(DACRT_PARTITION_BUY_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BUY_NODES_INL_H_
#undef DACRT_PARTITION_BUY_NODES_INL_H_
#else
#define DACRT_PARTITION_BUY_NODES_INL_H_
#endif

#include <optional>
#include <span>

#include "partition/keep_nodes-inl.h"
#include "partition/kept_partition.h"
#include "partition/nodes_over_leaves-inl.h"
#include "partition/rent_or_buy.h"
#include "partition/split_subset-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Writes the bits of a subset's leaves to `words`, where their first items stand. From then on
/// leaves get no copies in the old nodes; wrong ones stay theirs, and are renewed there.
inline void TakeLeaves(KeptPartition& kept, const Subset& subset, const NodeRun& nodes,
                       uint32_t* words) {
  kept.ForEachNode(nodes, [&](WideNode& node) {
    while (!node.TryLockLeaves()) node.WaitForLeaves();
    const uint32_t stale = node.StaleLeaves(node.UsedChildren());
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      if (!child.IsLeaf()) continue;
      const uint32_t place = kept.PlaceOfLeaf(child);
      const ChildWord word = stale >> k & 1 ? ChildWord::Range(place) : child;
      words[place - subset.begin] = word.bits();
    }
    node.SetLeavesDone(~stale);
    node.UnlockLeaves();
  });
}

/// Refers to the leaves into which triangles are cut, with these bits. Returns how many there are.
inline size_t ReferLeaves(std::span<const uint32_t> order, const TriangleRef* triangles,
                          const uint32_t* words, TriangleRef* leaves) {
  size_t count = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const ChildWord word(words[i]);
    Extent bounds = Extent::Of(triangles[i]);
    while (!(order[i] & KeptOrder::kLastOfLeaf)) bounds.Join(Extent::Of(triangles[++i]));
    leaves[count++] = ReferLeaf(bounds, word);
  }
  return count;
}

/// Buys nodes for a subset whose nodes are rented; nobody else may do so meanwhile. Where there is
/// no room, what is rented will do, with copies.
inline void BuyNodes(KeptPartition& kept, Subset& subset, SubsetScratch& scratch) {
  const NodeRun rented{Subset::NodeOf(subset.root), subset.node_slots};
  const std::span<const uint32_t> order = kept.OrderOf(subset);
  const Box bounds = ReferTriangles(kept.geometries(), order, scratch.spare).bounds;
  TakeLeaves(kept, subset, rented, scratch.words);
  const size_t leaves = ReferLeaves(order, scratch.spare, scratch.words, scratch.refs);
  const size_t count = MakeNodesOver({scratch.refs, leaves}, scratch);
  uint32_t no_subset;
  std::optional<NodeRun> nodes;
  if (count > 0) nodes = KeepNodes(kept, {scratch.nodes, count}, 0, no_subset);
  if (!nodes) {
    kept.ForEachNode(rented, [](WideNode& node) { node.SetLeavesBare(); });
    return Publish(kept, subset, rented.first);
  }
  SetNodes(kept, subset, *nodes, bounds);
  kept.HasItsNodes(subset, *nodes);
  subset.rented = rented.bits();
  Publish(kept, subset, nodes->first);
  rent_or_buy::GiveBackRented(kept, subset);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_BUY_NODES_INL_H_
