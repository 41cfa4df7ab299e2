// Nodes of least surface over the leaves that a small subset has: bought once its packed ones have
// cost as much (rent_or_buy.h). Leaves stay as they are, and whoever walks the old nodes goes on.

#if defined(DACRT_PARTITION_BUY_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BUY_NODES_INL_H_
#undef DACRT_PARTITION_BUY_NODES_INL_H_
#else
#define DACRT_PARTITION_BUY_NODES_INL_H_
#endif

#include "partition/keep_nodes-inl.h"
#include "partition/kept_partition.h"
#include "partition/rent_or_buy.h"
#include "partition/split_subset-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Buys nodes for a subset whose nodes are rented; nobody else may do so meanwhile. They come with
/// another order of the triangles, beside the one by which the rented nodes go, and the hits that
/// rays have found there. Where there is no room, what is rented will do.
inline void BuyNodes(KeptPartition& kept, Subset& subset, SubsetScratch& scratch) {
  const NodeRun rented{Subset::NodeOf(subset.root), subset.node_count};
  const uint32_t begin = subset.begin;
  uint32_t root = Subset::kNoRoom, place = subset.spare;
  NodeRun run;
  if (place != Subset::kNowhere || kept.AllocateOrder(subset.count, run, place)) {
    root = SplitSmallSubset(kept, subset, UINT32_MAX, place, scratch);
  }
  if (root == Subset::kNoRoom) {
    if (run.count > 0) kept.Free(run);
    for (uint32_t i = 0; i < rented.count; ++i) kept.node(rented.first + i).SetLeavesBare();
    return Publish(kept, subset, rented.first);
  }
  subset.spare = begin;
  subset.rented = rented.bits();
  Publish(kept, subset, root);
  rent_or_buy::GiveBackRented(kept, subset);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_BUY_NODES_INL_H_
