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

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Makes references to the triangles of `order`.
inline TriangleRange ReferTriangles(const GeometryTable& geometries,
                                    std::span<const uint32_t> order, TriangleRef* refs) {
  ReadAhead names(geometries, order);
  CornerBounds bounds, centers;
  for (size_t i = 0; i < order.size(); ++i) {
    const GeometryTable::Name name = names.Next();
    const auto [lower, upper] = BoundUsable(geometries, names.source(), name);
    bounds.Extend(lower, upper);
    centers.Extend(TwiceCenter(lower, upper));
    lower.Store(refs[i].lower);
    upper.Store(refs[i].upper);
    refs[i].primitive = name.primitive;
    refs[i].geometry = name.geometry;
  }
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

/// How nodes are made over leaves that stand along a curve: in so little time that it pays for few
/// rays, or so that rays are traced a tenth faster.
enum class NodeRule { kRent, kBuy };

/// Nodes over the first `leaf_count` of scratch.packed, in scratch.nodes; scratch.refs is scrap
/// afterwards. Returns how many they are, 0 if they have no room.
template <class Leaves>
inline size_t MakeNodesOver(size_t leaf_count, const Box& bounds, NodeRule rule, Leaves& leaves,
                            SubsetScratch& scratch) {
  if (rule == NodeRule::kRent) return PackNodes(bounds, leaf_count, leaves, scratch);
  for (size_t i = 0; i < leaf_count; ++i) {
    const PackedRange& leaf = scratch.packed[i];
    ReferLeaf(leaf, leaves.Child(leaf.begin, leaf.end), scratch.refs[i]);
  }
  return BuildNodesOver(MeasureTriangles(scratch.refs, 0, leaf_count), scratch);
}

/// Splits the triangles of `order`, whose place in the kept order is `first`, into nodes in
/// scratch.nodes, with leaves of `leaf_lanes` lanes, and orders them anew. Returns the number of
/// nodes, 0 if they have no room, and the bounds of the triangles if they are asked for.
inline size_t SplitTriangles(const GeometryTable& geometries, size_t leaf_lanes, uint32_t first,
                             std::span<uint32_t> order, NodeRule rule, SubsetScratch& scratch,
                             Box* bounds = nullptr) {
  DACRT_ASSERT(!order.empty() && order.size() <= SubsetScratch::kTriangles);
  // Where leaves are large nodes have no room for what curves cost.
  const bool packs = leaf_lanes == kLeafLanes;
  const TriangleRange range =
      ReferTriangles(geometries, order, packs ? scratch.spare : scratch.refs);
  if (bounds) *bounds = range.bounds;
  std::fill_n(scratch.is_last, order.size(), false);
  TriangleLeaves leaves{leaf_lanes, first, scratch.is_last};
  const auto name_triangles = [&] {
    for (size_t i = 0; i < order.size(); ++i) {
      order[i] = geometries.Number(scratch.refs[i].geometry, scratch.refs[i].primitive);
    }
  };
  const auto split = [&](const auto& kind) {
    if (packs) {
      SortAlongCurve(range, scratch);
      const size_t leaf_count = PackLeaves(kind, range, scratch);
      name_triangles();
      return MakeNodesOver(leaf_count, range.bounds, rule, leaves, scratch);
    }
    size_t weight = 0;
    for (size_t i = 0; i < order.size(); ++i) weight += kind.Weight(scratch.refs[i]);
    const size_t count = NodeBuilder(kind, scratch.refs, leaves, std::span(scratch.ranges),
                                     std::span(scratch.nodes), scratch)
                             .Build({range, weight});
    name_triangles();
    return count;
  };
  const size_t count =
      geometries.all_fill_one_lane() ? split(Triangles()) : split(Items{geometries});
  for (size_t i = 0; i < order.size(); ++i) {
    if (scratch.is_last[i]) order[i] |= KeptOrder::kLastOfLeaf;
  }
  return count;
}

/// Returns the number of the root, or Subset::kNoRoom, after which everything is as it was. The
/// nodes may take the place of `old`. They are rented unless `rays` rays are enough to buy.
inline uint32_t SplitSmallSubset(KeptPartition& kept, Subset& subset, size_t rays,
                                 SubsetScratch& scratch, const NodeRun& old = {}) {
  // In private memory until there is room: others may still read the order.
  uint32_t* const order = scratch.order;
  const auto triangles = kept.triangles().subspan(subset.begin, subset.count);
  std::transform(triangles.begin(), triangles.end(), order, KeptOrder::NumberOf);
  Box bounds;
  const NodeRule rule =
      rays < rent_or_buy::RaysFor(subset.count) ? NodeRule::kRent : NodeRule::kBuy;
  const size_t count = SplitTriangles(kept.geometries(), kept.leaf_lanes(), subset.begin,
                                      {order, subset.count}, rule, scratch, &bounds);
  if (count == 0) return Subset::kNoRoom;
  // There is nothing better than one node, or than what was split by surface.
  const bool is_rented = rule == NodeRule::kRent && count > 1 && kept.leaf_lanes() == kLeafLanes;
  if (is_rented) {
    for (size_t i = 0; i < count; ++i) scratch.nodes[i].SetLeavesDone();
  }
  uint32_t no_subset;
  const uint32_t root = KeepNodes(kept, {scratch.nodes, count}, 0, no_subset, old);
  if (root == Subset::kNoRoom) return root;
  std::copy_n(order, subset.count, triangles.begin());
  subset.node_count = static_cast<uint32_t>(count);
  subset.decay_base = RelativeSurface({&kept.node(root), count}, bounds);
  subset.rays = 0;
  if (!is_rented) kept.HasItsNodes(subset, count);
  return is_rented ? root | Subset::kRented : root;
}

/// Room that the copies of a subset's leaves take.
inline size_t LeafRoomOf(KeptPartition& kept, std::span<const WideNode> nodes) {
  size_t bytes = 0;
  for (const WideNode& node : nodes) {
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      if (child.IsBlock()) bytes += kept.RoomOfLeaf(child.block());
    }
  }
  return bytes;
}

/// Splits a subset anew that has nodes which fit its triangles no longer. Returns the number of the
/// root.
inline uint32_t SplitAnew(KeptPartition& kept, Subset& subset, uint32_t root, size_t rays,
                          SubsetScratch& scratch) {
  const NodeRun old{root, subset.node_count};
  const size_t leaf_room = LeafRoomOf(kept, {&kept.node(root), old.count});
  const uint32_t anew = SplitSmallSubset(kept, subset, rays, scratch, old);
  if (anew == Subset::kNoRoom) return root;
  if (Subset::NodeOf(anew) == root) {
    kept.Lose((old.count - subset.node_count) * sizeof(WideNode));
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
