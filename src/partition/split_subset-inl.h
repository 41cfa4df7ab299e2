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
#include "partition/pack_along_curve-inl.h"
#include "partition/read_ahead-inl.h"
#include "partition/sort_along_curve-inl.h"
#include "partition/split_along_curve-inl.h"

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

/// How triangles are split: in so little time that it pays for one frame, or so that rays are
/// traced some percent faster.
enum class SplitRule { kFast, kWell };

/// Triangles up to which ranges are split on three axes. Sponza, nodes of least surface, ms for the
/// first 1,024 rays, ns a diffuse and a shadow ray of 65,536 when it is split: with 32 24.3, 215;
/// 64 25.9, 196, 58.8; 128 27.6, 196, 54.6. Where leaves are large nodes have no room for what
/// curves cost, and it is all.
constexpr size_t BySurface(size_t leaf_lanes) {
  return leaf_lanes > kLeafLanes ? SubsetScratch::kTriangles : 128;
}

/// Splits the triangles of `order`, whose place in the kept order is `first`, into nodes in
/// scratch.nodes, with leaves of `leaf_lanes` lanes, and orders them anew. Returns the number of
/// nodes, 0 if they have no room, and the bounds of the triangles if they are asked for.
inline size_t SplitTriangles(const GeometryTable& geometries, size_t leaf_lanes, uint32_t first,
                             std::span<uint32_t> order, SplitRule rule, SubsetScratch& scratch,
                             Box* bounds = nullptr) {
  DACRT_ASSERT(!order.empty() && order.size() <= SubsetScratch::kTriangles);
  const bool one_lane_each = geometries.all_fill_one_lane();
  const bool packs = rule == SplitRule::kFast && leaf_lanes == kLeafLanes;
  const bool has_curve = packs || one_lane_each;
  const TriangleRange range =
      ReferTriangles(geometries, order, has_curve ? scratch.spare : scratch.refs);
  if (bounds) *bounds = range.bounds;
  if (has_curve) SortAlongCurve(range, scratch);
  std::fill_n(scratch.is_last, order.size(), false);
  TriangleLeaves leaves{leaf_lanes, first, scratch.is_last};
  const auto split = [&](const auto& kind, size_t weight) {
    return NodeBuilder(kind, scratch.refs, leaves, std::span(scratch.ranges),
                       std::span(scratch.nodes), scratch)
        .Build({range, weight});
  };
  const Items items{geometries};
  size_t count;
  if (packs && one_lane_each) {
    count = PackAlongCurve(Triangles(), range, leaves, scratch);
  } else if (packs) {
    count = PackAlongCurve(items, range, leaves, scratch);
  } else if (one_lane_each) {
    count = split(AlongCurve{scratch.codes[0], BySurface(leaf_lanes)}, range.count());
  } else {
    size_t weight = 0;
    for (size_t i = 0; i < order.size(); ++i) weight += items.Weight(scratch.refs[i]);
    count = split(items, weight);
  }
  if (count == 0) return 0;
  for (size_t i = 0; i < order.size(); ++i) {
    order[i] = geometries.Number(scratch.refs[i].geometry, scratch.refs[i].primitive);
    if (scratch.is_last[i]) order[i] |= KeptOrder::kLastOfLeaf;
  }
  return count;
}

/// Nodes in a row.
struct NodeRun {
  uint32_t first = 0;
  uint32_t count = 0;
};

/// Appends nodes whose numbers count from the first of them, or writes them over those of `old` if
/// they fit, and makes room for `subset_count` subsets, whose numbers do, too. Returns the number
/// of the first node, or Subset::kNoRoom.
inline uint32_t KeepNodes(KeptPartition& kept, std::span<const WideNode> nodes, size_t subset_count,
                          uint32_t& first_subset, const NodeRun& old = {}) {
  uint32_t first_node = old.first;
  if (nodes.size() > old.count &&
      !kept.Allocate(nodes.size(), subset_count, first_node, first_subset)) {
    return Subset::kNoRoom;
  }
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

/// The surface of all volumes of some nodes, relative to that of the box around them all: what a
/// ray that meets the box costs in tests.
inline float RelativeSurface(std::span<const WideNode> nodes, const Box& own) {
  float surface = 0;
  for (const WideNode& node : nodes) {
    float step[3];
    for (int axis = 0; axis < 3; ++axis) step[axis] = FromUpperHalf(node.scale[axis]);
    for (size_t k = 0; k < node.count; ++k) {
      float edge[3];
      for (int axis = 0; axis < 3; ++axis) {
        edge[axis] = step[axis] * static_cast<float>(node.upper[axis][k] - node.lower[axis][k]);
      }
      surface += edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0];
    }
  }
  const float all = own.HalfArea();
  return all > 0 ? surface / all : 0;
}

/// Returns the number of the root, or Subset::kNoRoom, after which everything is as it was. The
/// nodes take the place of `old` if they fit.
inline uint32_t SplitSmallSubset(KeptPartition& kept, Subset& subset, SubsetScratch& scratch,
                                 const NodeRun& old = {}) {
  // In private memory until there is room: others may still read the order.
  uint32_t* const order = scratch.order;
  const auto triangles = kept.triangles().subspan(subset.begin, subset.count);
  std::transform(triangles.begin(), triangles.end(), order, KeptOrder::NumberOf);
  Box bounds;
  const SplitRule rule = kept.is_short_lived() ? SplitRule::kFast : SplitRule::kWell;
  const size_t count = SplitTriangles(kept.geometries(), kept.leaf_lanes(), subset.begin,
                                      {order, subset.count}, rule, scratch, &bounds);
  if (count == 0) return Subset::kNoRoom;
  uint32_t no_subset;
  const uint32_t root = KeepNodes(kept, {scratch.nodes, count}, 0, no_subset, old);
  if (root == Subset::kNoRoom) return root;
  std::copy_n(order, subset.count, triangles.begin());
  subset.node_count = static_cast<uint32_t>(count);
  subset.decay_base = RelativeSurface({&kept.node(root), count}, bounds);
  return root;
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
inline uint32_t SplitAnew(KeptPartition& kept, Subset& subset, uint32_t root,
                          SubsetScratch& scratch) {
  const NodeRun old{root, subset.node_count};
  const size_t leaf_room = LeafRoomOf(kept, {&kept.node(root), old.count});
  const uint32_t anew = SplitSmallSubset(kept, subset, scratch, old);
  if (anew == Subset::kNoRoom) return root;
  const uint32_t used = anew == root ? subset.node_count : 0;
  kept.Lose(leaf_room + (old.count - used) * sizeof(WideNode));
  return anew;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_SUBSET_INL_H_
