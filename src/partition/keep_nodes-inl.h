// Nodes that have been made in private memory, into the kept partition.

#if defined(DACRT_PARTITION_KEEP_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_KEEP_NODES_INL_H_
#undef DACRT_PARTITION_KEEP_NODES_INL_H_
#else
#define DACRT_PARTITION_KEEP_NODES_INL_H_
#endif

#include <optional>
#include <span>

#include "geometry/wide_node-inl.h"
#include "partition/kept_partition.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Copies nodes, which are referred to as InnerOfExact, behind those that there are, or over those
/// of `old` if there is no other room and they fit, and makes room for `subset_count` subsets,
/// whose numbers count from the first, too. They stay exact if there is room for that. Returns
/// where they are, or nothing if there is no room at all.
inline std::optional<NodeRun> KeepNodes(KeptPartition& kept, std::span<const ExactNode> nodes,
                                        size_t subset_count, uint32_t& first_subset,
                                        const NodeRun& old = {}) {
  NodeRun run;
  const auto allocate = [&](size_t slots) {
    run.count = static_cast<uint32_t>(slots * nodes.size());
    return kept.Allocate(run.count, subset_count, run.first, first_subset);
  };
  bool is_exact = kept.TakeExactRoom(nodes.size());
  if (is_exact && !allocate(WideNode::kExactSlots)) {
    kept.ReturnExactRoom(nodes.size());
    is_exact = false;
  }
  if (!is_exact && !allocate(1)) {
    if (nodes.size() > old.count) return std::nullopt;
    kept.ReturnExactRoom(old);
    run.first = old.first;
  }
  const uint32_t slots = is_exact ? WideNode::kExactSlots : 1;
  const auto number_of = [&](uint32_t number) {
    return run.first + number / WideNode::kExactSlots * slots;
  };
  for (size_t i = 0; i < nodes.size(); ++i) {
    const uint32_t number = number_of(InnerOfExact(i).number());
    WideNode& node = kept.node(number);
    if (is_exact) {
      static_cast<ExactNode&>(node) = nodes[i];
    } else {
      node = nodes[i];
      node.is_exact = false;
      ChildFaces().Encode(nodes[i], node);
    }
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = nodes[i].Child(k);
      if (child.IsInner()) node.SetChild(k, ChildWord::Inner(number_of(child.number())));
      if (!child.IsSubset()) continue;
      node.SetChild(k, ChildWord::Subset(first_subset + child.number()));
      kept.subset(first_subset + child.number()).parent =
          static_cast<uint32_t>(number * WideNode::kWidth + k);
    }
  }
  return run;
}

/// The surface of all volumes of some nodes, relative to that of the box around them all: what a
/// ray that meets the box costs in tests.
inline float RelativeSurface(const KeptPartition& kept, const NodeRun& nodes, const Box& own) {
  EightPart surfaces = hn::Zero(kEightTag);
  kept.ForEachNode(nodes, [&](const WideNode& node) HWY_ATTR {
    const ChildPlanes planes(node, PlaneOffsets(0));
    for (size_t part = 0; part < kParts; ++part) {
      EightPart edge[3];
      for (int axis = 0; axis < 3; ++axis) {
        // Children that are not there are inside out.
        edge[axis] =
            hn::Max(hn::Sub(planes.far[part][axis], planes.near[part][axis]), hn::Zero(kEightTag));
      }
      surfaces =
          hn::MulAdd(edge[0], hn::Add(edge[1], edge[2]), hn::MulAdd(edge[1], edge[2], surfaces));
    }
  });
  const float surface = hn::GetLane(hn::SumOfLanes(kEightTag, surfaces));
  const float all = own.HalfArea();
  return all > 0 ? surface / all : 0;
}

/// Says which nodes a subset has, whose triangles have these bounds.
inline void SetNodes(const KeptPartition& kept, Subset& subset, const NodeRun& nodes,
                     const Box& bounds) {
  subset.node_slots = nodes.count;
  subset.decay_base = RelativeSurface(kept, nodes, bounds);
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
