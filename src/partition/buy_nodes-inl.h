// Nodes of least surface over the leaves that a small subset has: bought once its packed ones have
// cost as much (rent_or_buy.h). Leaves stay as they are, and whoever walks the old nodes goes on.

#if defined(DACRT_PARTITION_BUY_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BUY_NODES_INL_H_
#undef DACRT_PARTITION_BUY_NODES_INL_H_
#else
#define DACRT_PARTITION_BUY_NODES_INL_H_
#endif

#include <span>

#include "geometry/bound_triangle-inl.h"
#include "partition/keep_nodes-inl.h"
#include "partition/kept_partition.h"
#include "partition/nodes_over_leaves-inl.h"
#include "partition/read_ahead-inl.h"
#include "partition/rent_or_buy.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Refers to the leaves of a subset that has been split. Returns how many they are.
inline size_t ReferLeaves(const GeometryTable& geometries, const Subset& subset,
                          std::span<const uint32_t> order, TriangleRef* refs) {
  ReadAhead names(geometries, order);
  CornerBounds bounds;
  size_t leaves = 0, begin = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const GeometryTable::Name name = names.Next();
    const auto [lower, upper] = BoundUsable(geometries, names.source(), name);
    bounds.Extend(lower, upper);
    if (!(order[i] & KeptOrder::kLastOfLeaf)) continue;
    const auto first = static_cast<uint32_t>(subset.begin + begin);
    ReferLeaf(bounds.Get(), ChildWord::Range(first), refs[leaves++]);
    bounds = CornerBounds();
    begin = i + 1;
  }
  DACRT_ASSERT(begin == order.size());
  return leaves;
}

/// Buys nodes for a subset whose nodes are rented; nobody else may do so meanwhile. Where there is
/// no room for them those that there are will do.
inline void BuyNodes(KeptPartition& kept, Subset& subset, SubsetScratch& scratch) {
  const NodeRun rented{Subset::NodeOf(subset.root), subset.node_count};
  const auto order = kept.triangles().subspan(subset.begin, subset.count);
  const size_t leaves = ReferLeaves(kept.geometries(), subset, order, scratch.refs);
  const TriangleRange range = MeasureTriangles(scratch.refs, 0, leaves);
  const size_t count = BuildNodesOver(range, scratch);
  uint32_t root = Subset::kNoRoom, no_subset;
  if (count > 0) root = KeepNodes(kept, {scratch.nodes, count}, 0, no_subset);
  if (root == Subset::kNoRoom) {
    for (uint32_t i = 0; i < rented.count; ++i) kept.node(rented.first + i).SetLeavesBare();
    return Publish(kept, subset, rented.first);
  }
  // What was rented is what the next one rents or buys, as far as it is long enough.
  kept.HasItsNodes(subset, HWY_MAX(rented.count, count));
  subset.rented = rented.bits();
  subset.node_count = static_cast<uint32_t>(count);
  subset.decay_base = RelativeSurface({&kept.node(root), count}, range.bounds);
  Publish(kept, subset, root);
  rent_or_buy::GiveBackRented(kept, subset);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_BUY_NODES_INL_H_
