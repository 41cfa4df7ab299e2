// Nodes that have been made in private memory, into the kept partition.

#if defined(DACRT_PARTITION_KEEP_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_KEEP_NODES_INL_H_
#undef DACRT_PARTITION_KEEP_NODES_INL_H_
#else
#define DACRT_PARTITION_KEEP_NODES_INL_H_
#endif

#include <span>

#include "geometry/wide_node-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Appends nodes whose numbers count from the first of them, or writes them over those of `old` if
/// there is no other room and they fit, and makes room for `subset_count` subsets, whose numbers
/// do, too. Returns the number of the first node, or Subset::kNoRoom.
inline uint32_t KeepNodes(KeptPartition& kept, std::span<const WideNode> nodes, size_t subset_count,
                          uint32_t& first_subset, const NodeRun& old = {}) {
  uint32_t first_node;
  if (!kept.Allocate(nodes.size(), subset_count, first_node, first_subset)) {
    if (nodes.size() > old.count) return Subset::kNoRoom;
    first_node = old.first;
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
  const hn::RebindToSigned<EightTag> di;
  const hn::Rebind<uint8_t, EightTag> d8;
  EightPart surfaces = hn::Zero(kEightTag);
  for (const WideNode& node : nodes) {
    for (size_t part = 0; part < kParts; ++part) {
      const size_t first = part * kPartLanes;
      EightPart edge[3];
      for (int axis = 0; axis < 3; ++axis) {
        // Children that are not there are inside out.
        const auto steps =
            hn::Max(hn::Sub(hn::PromoteTo(di, hn::LoadU(d8, node.upper[axis] + first)),
                            hn::PromoteTo(di, hn::LoadU(d8, node.lower[axis] + first))),
                    hn::Zero(di));
        edge[axis] = hn::Mul(hn::ConvertTo(kEightTag, steps), hn::Set(kEightTag, node.scale[axis]));
      }
      surfaces =
          hn::MulAdd(edge[0], hn::Add(edge[1], edge[2]), hn::MulAdd(edge[1], edge[2], surfaces));
    }
  }
  const float surface = hn::GetLane(hn::SumOfLanes(kEightTag, surfaces));
  const float all = own.HalfArea();
  return all > 0 ? surface / all : 0;
}

/// Says which nodes a subset has, whose triangles have these bounds.
inline void SetNodes(const KeptPartition& kept, Subset& subset, const NodeRun& nodes,
                     const Box& bounds) {
  subset.node_count = nodes.count;
  subset.decay_base = RelativeSurface({&kept.node(nodes.first), nodes.count}, bounds);
}

/// Says what stands behind a subset now. Whoever waits for that goes on.
inline void Publish(KeptPartition& kept, Subset& subset, uint32_t root) {
  subset.root = root;
  subset.root.notify_all();
  if (Subset::IsNode(root) && subset.parent != Subset::kNowhere) {
    kept.node(subset.parent / WideNode::kWidth)
        .SetChild(subset.parent % WideNode::kWidth, ChildWord::Inner(root));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_KEEP_NODES_INL_H_
