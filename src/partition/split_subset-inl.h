// Splitting a small subset of the kept partition, in the private memory of a thread.

#if defined(DACRT_PARTITION_SPLIT_SUBSET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#undef DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#else
#define DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#endif

#include "geometry/bound_triangle-inl.h"
#include "partition/build_nodes-inl.h"
#include "partition/keep_nodes-inl.h"
#include "partition/kept_partition.h"
#include "partition/nodes_over_leaves-inl.h"
#include "partition/pack_along_curve-inl.h"
#include "partition/read_ahead-inl.h"
#include "partition/rent_or_buy.h"
#include "partition/sort_along_curve-inl.h"
#include "partition/sort_by_surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Makes references to the triangles of `order`.
inline TriangleRange ReferTriangles(const GeometryTable& geometries,
                                    std::span<const uint32_t> order, TriangleRef* refs) {
  CornerBounds bounds, centers;
  ForEachReadAhead(geometries, order,
                   [&](size_t i, GeometryTable::Name name, const CornerSource& source) HWY_ATTR {
                     const auto [lower, upper] = BoundUsable(geometries, source, name);
                     bounds.Extend(lower, upper);
                     centers.Extend(TwiceCenter(lower, upper));
                     lower.Store(refs[i].lower);
                     upper.Store(refs[i].upper);
                     refs[i].primitive = name.primitive;
                     refs[i].geometry = name.geometry;
                   });
  return {0, order.size(), bounds.Get(), centers.Get()};
}

/// Leaves with a few triangles.
struct TriangleLeaves {
  bool IsLeaf(const WeighedRange& child) const {
    return child.weight <= lanes || child.range.count() == 1;
  }
  ChildWord Child(const BinaryRange& child) { return Child(child.begin, child.end); }
  ChildWord Child(uint32_t begin, uint32_t end) {
    is_last[end - 1] = true;
    return ChildWord::Range(first + begin);
  }

  size_t lanes;    ///< of a leaf
  uint32_t first;  ///< place of the first triangle in the order
  bool* is_last;   ///< of its leaf, for each triangle
};

/// How triangles that are not split one by one become leaves and nodes, for ever more rays.
enum class SplitRule {
  kRent,  ///< leaves that a curve is cut into, and nodes that are packed along it
  kBuy,   ///< over the same leaves nodes of least surface: rays take a tenth less
  /// Such nodes, over leaves that have less surface, too (see sort_by_surface-inl.h), and smaller
  /// ones where their geometry is not kept.
  kCare
};

/// Triangles up to which they are split one by one, on three axes, which costs next to nothing
/// then. In the leaves into which a curve is cut rays take up to 8 % longer in a box of 36
/// triangles.
constexpr size_t kOneByOne = 64;

/// Whether so many triangles are cut into leaves along a curve, over which nodes are made. Where
/// leaves are large, nodes have no room for what that costs.
constexpr bool HasCurve(size_t triangles, size_t leaf_lanes) {
  return triangles > kOneByOne && leaf_lanes == kLeafLanes;
}

/// Splits the triangles of `range`, which begins with scratch.refs, one by one. Returns the number
/// of nodes, 0 if they have no room.
template <class Kind>
inline size_t SplitOneByOne(const Kind& kind, const TriangleRange& range, TriangleLeaves& leaves,
                            SubsetScratch& scratch) {
  size_t weight = 0;
  for (size_t i = 0; i < range.count(); ++i) weight += kind.Weight(scratch.refs[i]);
  return NodeBuilder(kind, ReinsertionEffort{}, scratch.refs, leaves, std::span(scratch.ranges),
                     std::span(scratch.nodes), scratch)
      .Build({range, weight});
}

/// Splits those that stand along a curve. Returns the same; the references are gone then.
template <class Kind>
inline size_t SplitAlongCurve(const Kind& kind, const TriangleRange& range, SplitRule rule,
                              TriangleLeaves& leaves, SubsetScratch& scratch) {
  const size_t count = PackLeaves(kind, range, scratch);
  if (rule == SplitRule::kRent) return PackNodes(range.bounds, count, leaves, scratch);
  for (size_t i = 0; i < count; ++i) {
    const PackedRange& leaf = scratch.packed[i];
    scratch.refs[i] = ReferLeaf(Extent::Of(leaf), leaves.Child(leaf.begin, leaf.end));
  }
  return MakeNodesOver({scratch.refs, count}, scratch);
}

/// Splits the triangles of `order`, whose place in the kept order is `first`, into nodes in
/// scratch.nodes, with leaves of `leaf_lanes` lanes, and orders them anew. Returns the number of
/// nodes, 0 if they have no room, and the bounds of the triangles if they are asked for.
inline size_t SplitTriangles(const GeometryTable& geometries, size_t leaf_lanes, uint32_t first,
                             std::span<uint32_t> order, SplitRule rule, SubsetScratch& scratch,
                             Box* bounds = nullptr) {
  DACRT_ASSERT(!order.empty() && order.size() <= SubsetScratch::kTriangles);
  const bool has_curve = HasCurve(order.size(), leaf_lanes);
  const TriangleRange range =
      ReferTriangles(geometries, order, has_curve ? scratch.spare : scratch.refs);
  if (bounds) *bounds = range.bounds;
  std::fill_n(scratch.is_last, order.size(), false);
  TriangleLeaves leaves{leaf_lanes, first, scratch.is_last};
  const auto name = [&] {
    for (size_t i = 0; i < order.size(); ++i) {
      order[i] = geometries.Number(scratch.refs[i].geometry, scratch.refs[i].primitive);
    }
  };
  const auto split = [&](const auto& kind) {
    if (!has_curve) {
      const size_t count = SplitOneByOne(kind, range, leaves, scratch);
      name();
      return count;
    }
    SortAlongCurve(range, scratch);
    if (rule == SplitRule::kCare) SortBySurface(kind, range.count(), scratch);
    name();
    return SplitAlongCurve(kind, range, rule, leaves, scratch);
  };
  const size_t count =
      geometries.all_fill_one_lane() ? split(Triangles()) : split(Items{geometries});
  for (size_t i = 0; i < order.size(); ++i) {
    if (scratch.is_last[i]) order[i] |= KeptOrder::kLastOfLeaf;
  }
  return count;
}

/// Splits a small subset. Returns the number of the root, or Subset::kNoRoom, after which
/// everything is as it was. The nodes may take the place of `old`, of triangles that move then, for
/// which nobody cares. They are rented unless `rays` rays are enough to buy, or there are no better
/// ones.
inline uint32_t SplitSmallSubset(KeptPartition& kept, Subset& subset, size_t rays,
                                 SubsetScratch& scratch, const NodeRun& old = {}) {
  // In private memory until there is room: others may still read the order.
  uint32_t* const order = scratch.order;
  const auto triangles = kept.OrderOf(subset);
  Box bounds;
  SplitRule rule =
      rays >= rent_or_buy::kNodes.RaysFor(subset.count) ? SplitRule::kBuy : SplitRule::kRent;
  if (kept.splits_with_care() && old.count == 0) rule = SplitRule::kCare;
  const auto split = [&](size_t leaf_lanes) {
    std::transform(triangles.begin(), triangles.end(), order, KeptOrder::NumberOf);
    return SplitTriangles(kept.geometries(), leaf_lanes, subset.begin, {order, subset.count}, rule,
                          scratch, &bounds);
  };
  const size_t share = kept.NodeShareOf(subset);
  size_t leaf_lanes = rule == SplitRule::kCare ? kept.tried_leaf_lanes() : kept.leaf_lanes();
  size_t count = split(leaf_lanes);
  while (count > share && leaf_lanes < kept.leaf_lanes()) {
    leaf_lanes = HWY_MIN(leaf_lanes * count / share + 1, kept.leaf_lanes());
    count = split(leaf_lanes);
  }
  if (count == 0) return Subset::kNoRoom;
  const bool has_better = count > 1 && HasCurve(subset.count, kept.leaf_lanes());
  const bool is_rented = rule == SplitRule::kRent && has_better;
  if (rule != SplitRule::kBuy && has_better) {
    for (size_t i = 0; i < count; ++i) scratch.nodes[i].SetLeavesUnvisited();
  }
  uint32_t no_subset;
  const auto nodes = KeepNodes(kept, {scratch.nodes, count}, 0, no_subset, old);
  if (!nodes) return Subset::kNoRoom;
  std::copy_n(order, subset.count, triangles.begin());
  SetNodes(kept, subset, *nodes, bounds);
  if (!is_rented) {
    kept.HasItsNodes(subset, *nodes);
    return nodes->first;
  }
  subset.rays = 0;
  return nodes->first | Subset::kRented;
}

/// Room that the copies of a subset's leaves take.
inline size_t LeafRoomOf(KeptPartition& kept, const NodeRun& nodes) {
  size_t bytes = 0;
  kept.ForEachNode(nodes, [&](const WideNode& node) {
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      if (child.IsBlock()) bytes += kept.RoomOfLeaf(child.block());
    }
  });
  return bytes;
}

/// Splits a subset anew that has nodes which fit its triangles no longer. Returns the number of the
/// root.
inline uint32_t SplitAnew(KeptPartition& kept, Subset& subset, uint32_t root, size_t rays,
                          SubsetScratch& scratch) {
  const NodeRun old{root, subset.node_slots};
  const size_t leaf_room = LeafRoomOf(kept, old);
  const uint32_t anew = SplitSmallSubset(kept, subset, rays, scratch, old);
  if (anew == Subset::kNoRoom) return root;
  if (Subset::NodeOf(anew) == root) {
    kept.Lose((old.count - subset.node_slots) * sizeof(WideNode));
  } else {
    kept.Free(old);
  }
  kept.Lose(leaf_room);
  return anew;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_SUBSET_INL_H_
