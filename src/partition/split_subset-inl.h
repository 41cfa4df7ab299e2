// Splitting a small subset of the kept partition, in the private memory of a thread.

#if defined(DACRT_PARTITION_SPLIT_SUBSET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#undef DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#else
#define DACRT_PARTITION_SPLIT_SUBSET_INL_H_
#endif

#include "geometry/bound_triangle-inl.h"
#include "partition/build_nodes-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Makes references to the triangles of `order`, at most SubsetScratch::kTriangles, in scratch.refs.
inline TriangleRange ReferTriangles(const MeshTable& meshes, std::span<const uint32_t> order,
                                    SubsetScratch& scratch) {
  for (size_t i = 0; i < order.size(); ++i) {
    const MeshTable::Name name = meshes.Locate(order[i]);
    const auto [lower, upper] = BoundUsable(meshes, name);
    TriangleRef& ref = scratch.refs[i];
    lower.Store(ref.lower);
    upper.Store(ref.upper);
    ref.primitive = name.primitive;
    ref.mesh = name.mesh;
  }
  return MeasureTriangles(scratch.refs, 0, order.size());
}

/// Leaves with a few triangles.
struct TriangleLeaves {
  size_t most() const { return lanes; }
  /// With leaves three quarters full.
  size_t most_of_node() const { return WideNode::kWidth * lanes * 3 / 4; }
  bool IsLeaf(const WeighedRange& child) const {
    return child.weight <= lanes || child.range.count() == 1;
  }
  ChildWord Child(const WeighedRange& child) {
    is_last[child.range.end - 1] = true;
    return ChildWord::Range(static_cast<uint32_t>(first + child.range.begin));
  }

  size_t lanes;    ///< of a leaf
  uint32_t first;  ///< place of the first triangle in the order
  bool* is_last;   ///< of its leaf, for each triangle
};

/// Splits the triangles of `order`, whose place in the kept order is `first`, into nodes in
/// scratch.nodes, with leaves of `leaf_lanes` lanes, and orders them anew. Returns the number of
/// nodes, 0 if they have no room.
inline size_t SplitTriangles(const MeshTable& meshes, size_t leaf_lanes, uint32_t first,
                             std::span<uint32_t> order, SubsetScratch& scratch) {
  DACRT_ASSERT(!order.empty() && order.size() <= SubsetScratch::kTriangles);
  const TriangleRange range = ReferTriangles(meshes, order, scratch);
  std::fill_n(scratch.is_last, order.size(), false);
  TriangleLeaves leaves{leaf_lanes, first, scratch.is_last};
  const std::span<WideNode> nodes(scratch.nodes);
  size_t count;
  if (meshes.all_fill_one_lane()) {
    count = NodeBuilder(Triangles(), scratch.refs, leaves, nodes, scratch)
                .Build({range, range.count()});
  } else {
    const Items items{meshes};
    size_t weight = 0;
    for (size_t i = 0; i < order.size(); ++i) weight += items.Weight(scratch.refs[i]);
    count = NodeBuilder(items, scratch.refs, leaves, nodes, scratch).Build({range, weight});
  }
  if (count == 0) return 0;
  for (size_t i = 0; i < order.size(); ++i) {
    order[i] = meshes.Number(scratch.refs[i].mesh, scratch.refs[i].primitive);
    if (scratch.is_last[i]) order[i] |= KeptOrder::kLastOfLeaf;
  }
  return count;
}

/// Appends nodes whose numbers count from the first of them, and makes room for `subset_count`
/// subsets, whose numbers do, too. Returns the number of the first node, or Subset::kNoRoom.
inline uint32_t KeepNodes(KeptPartition& kept, std::span<const WideNode> nodes, size_t subset_count,
                          uint32_t& first_subset) {
  uint32_t first_node;
  if (!kept.Allocate(nodes.size(), subset_count, first_node, first_subset)) return Subset::kNoRoom;
  for (size_t i = 0; i < nodes.size(); ++i) {
    const uint32_t number = static_cast<uint32_t>(first_node + i);
    WideNode& node = kept.node(number);
    node = nodes[i];
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = nodes[i].Child(k);
      if (child.IsInner()) node.SetChild(k, ChildWord::Inner(first_node + child.number()));
      if (!child.IsSubset()) continue;
      node.SetChild(k, ChildWord::Subset(first_subset + child.number()));
      kept.subset(first_subset + child.number()).parent =
          static_cast<uint32_t>(number * WideNode::kWidth + k);
    }
  }
  return first_node;
}

/// Returns the number of the root, or Subset::kNoRoom.
inline uint32_t SplitSmallSubset(KeptPartition& kept, const Subset& subset,
                                 SubsetScratch& scratch) {
  // In private memory until there is room: others may still read the order.
  uint32_t* const order = scratch.order;
  const auto triangles = kept.triangles().subspan(subset.begin, subset.count);
  std::copy(triangles.begin(), triangles.end(), order);
  const size_t count = SplitTriangles(kept.meshes(), kept.leaf_lanes(), subset.begin,
                                      {order, subset.count}, scratch);
  if (count == 0) return Subset::kNoRoom;
  uint32_t no_subset;
  const uint32_t root = KeepNodes(kept, {scratch.nodes, count}, 0, no_subset);
  if (root == Subset::kNoRoom) return root;
  std::copy_n(order, subset.count, triangles.begin());
  return root;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_SUBSET_INL_H_
