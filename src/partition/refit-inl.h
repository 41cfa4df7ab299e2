// Refit: new bounds in an old partition. Order and nodes stay as they are.
//
// Wald, Boulos, Shirley, "Ray tracing deformable scenes using dynamic bounding volume hierarchies",
// ACM TOG 26(1), 2007; when a hierarchy is better made anew: Lauterbach, Yoon, Tuft, Manocha,
// "RT-DEFORM: interactive ray tracing of dynamic scenes using BVHs", IEEE Symposium on Interactive
// Ray Tracing 2006.

#if defined(DACRT_PARTITION_REFIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_REFIT_INL_H_
#undef DACRT_PARTITION_REFIT_INL_H_
#else
#define DACRT_PARTITION_REFIT_INL_H_
#endif

#include <algorithm>
#include <atomic>

#include "geometry/bound_triangle-inl.h"
#include "partition/read_ahead-inl.h"
#include "partition/refit.h"
#include "partition/split_subset-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The bit of a mesh among Subset::mesh_bits.
inline uint64_t MeshBit(const MeshTable& meshes, uint32_t mesh) {
  return uint64_t{1} << (uint64_t{mesh} * 64 / meshes.meshes().size());
}

/// Looks at the triangles of a subset: `leaf(bounds)` is called with what precedes each mark in the
/// order, and what follows the last one. False if a triangle cannot be hit any more.
template <class Leaf>
bool LookAtSubset(const MeshTable& now, const std::vector<bool>& changed,
                  std::span<const uint32_t> order, RefittedSubset& refitted, const Leaf& leaf) {
  ReadAhead names(now, order);
  CornerBounds all, bounds;
  uint32_t last_mesh = UINT32_MAX;
  for (size_t i = 0; i < order.size(); ++i) {
    const MeshTable::Name name = names.Next();
    CornerBox box;
    if (HWY_UNLIKELY(!BoundIfUsable(now, name, box))) return false;
    bounds.Extend(box.lower, box.upper);
    if (HWY_UNLIKELY(name.mesh != last_mesh)) {
      last_mesh = name.mesh;
      refitted.mesh_bits |= MeshBit(now, name.mesh);
      refitted.is_stale |= changed[name.mesh];
    }
    if (!(order[i] & KeptOrder::kLastOfLeaf) && i + 1 < order.size()) continue;
    all.Extend(bounds.lower, bounds.upper);
    leaf(bounds.Get());
    bounds = CornerBounds();
  }
  refitted.bounds = all.Get();
  return true;
}

/// New volumes for nodes in a row, whose leaves have the given bounds, in the order of their
/// triangles. That is the order in which they stand in the tree: the children of a node are in it.
class NodeRefit {
 public:
  /// `root` is the number of the first node.
  NodeRefit(std::span<WideNode> nodes, uint32_t root, const Box* leaves)
      : nodes_(nodes), root_(root), next_leaf_(leaves) {}

  /// Returns the bounds of a node.
  Box Refit(uint32_t number) {
    WideNode& node = nodes_[number];
    Box boxes[WideNode::kWidth];
    const Box* pointers[WideNode::kWidth];
    CornerBounds all;
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      boxes[k] = child.IsInner() ? Refit(child.number() - root_) : *next_leaf_++;
      pointers[k] = &boxes[k];
      all.Extend(Corner::Load(boxes[k].lower), Corner::Load(boxes[k].upper));
    }
    EncodeChildren(pointers, node.count, node);
    return all.Get();
  }

 private:
  const std::span<WideNode> nodes_;
  const uint32_t root_;
  const Box* next_leaf_;
};

/// Plans the refit of a subset that has no others in it. False if a triangle cannot be hit any
/// more.
inline bool PlanUnit(const KeptPartition& kept, const Subset& subset, const MeshTable& now,
                     const std::vector<bool>& changed, RefittedSubset& refitted,
                     RefitPiece& piece) {
  const auto order = kept.triangles().subspan(subset.begin, subset.count);
  const uint32_t state = subset.root;
  if (state >= Subset::kNoRoom) {
    return LookAtSubset(now, changed, order, refitted, [](const Box&) {});
  }
  const uint32_t root = state & ~Subset::kStale;
  piece.leaves.clear();
  if (!LookAtSubset(now, changed, order, refitted,
                    [&](const Box& leaf) { piece.leaves.push_back(leaf); })) {
    return false;
  }
  if (!refitted.is_stale) return true;
  const size_t first = piece.nodes.size();
  const WideNode* const nodes = &kept.node(root);
  piece.nodes.insert(piece.nodes.end(), nodes, nodes + subset.node_count);
  const std::span<WideNode> own(piece.nodes.data() + first, subset.node_count);
  NodeRefit(own, root, piece.leaves.data()).Refit(0);
  refitted.has_decayed =
      RelativeSurface(own, refitted.bounds) > refit::kMostDecay * subset.decay_base;
  return true;
}

inline bool PlanRefit(const KeptPartition& kept, const MeshTable& now,
                      const std::vector<bool>& changed, bool always, TaskPool& tasks,
                      RefitPlan& plan) {
  if (kept.triangle_count() == 0 || kept.subset(0).root == Subset::kUnsplit) return false;
  if (kept.IsWornOut() && !always) return false;
  for (const uint32_t number : kept.left_out()) {
    CornerBox box;
    if (BoundIfUsable(now, now.Locate(number), box)) return false;
  }
  uint64_t changed_bits = 0;
  for (uint32_t mesh = 0; mesh < changed.size(); ++mesh) {
    if (changed[mesh]) changed_bits |= MeshBit(now, mesh);
  }
  const size_t count = kept.subset_count();
  plan.always = always;
  plan.subsets.assign(count, {});
  plan.pieces.resize((count + RefitPlan::kPiece - 1) / RefitPlan::kPiece);
  std::atomic<bool> is_possible{true};
  tasks.ForEach(plan.pieces.size(), [&](size_t piece) {
    const size_t begin = piece * RefitPlan::kPiece;
    for (size_t i = begin; i < std::min(count, begin + RefitPlan::kPiece); ++i) {
      const Subset& subset = kept.subset(static_cast<uint32_t>(i));
      RefittedSubset& refitted = plan.subsets[i];
      refitted.is_unit = !Subset::IsNode(subset.root) || subset.count <= SubsetScratch::kTriangles;
      if (!refitted.is_unit) continue;
      if (subset.mesh_bits != 0 && !(subset.mesh_bits & changed_bits)) {
        std::copy_n(subset.lower, 3, refitted.bounds.lower);
        std::copy_n(subset.upper, 3, refitted.bounds.upper);
        refitted.mesh_bits = subset.mesh_bits;
      } else if (is_possible &&
                 !PlanUnit(kept, subset, now, changed, refitted, plan.pieces[piece])) {
        is_possible = false;
      }
    }
  });
  if (!is_possible) return false;
  plan.bounds = Box::Empty();
  size_t most_nodes = 0;
  float surface = 0, made_surface = 0;
  for (size_t i = 0; i < count; ++i) {
    const Subset& subset = kept.subset(static_cast<uint32_t>(i));
    const RefittedSubset& refitted = plan.subsets[i];
    if (!refitted.is_unit) {
      most_nodes = std::max<size_t>(most_nodes, subset.node_count);
      continue;
    }
    surface += refitted.bounds.HalfArea();
    made_surface += subset.made_surface;
    plan.bounds.Extend(refitted.bounds.lower);
    plan.bounds.Extend(refitted.bounds.upper);
  }
  plan.node_bounds.resize(most_nodes);
  const float all = plan.bounds.HalfArea(), made_all = kept.subset(0).made_surface;
  return always || !(surface * made_all > refit::kMostDecay * made_surface * all);
}

/// New bounds for the nodes between a subset and the subsets in it. Returns its own.
inline Box RefitOver(KeptPartition& kept, const Subset& subset, RefitPlan& plan) {
  const uint32_t root = subset.root;
  for (uint32_t i = subset.node_count; i-- > 0;) {
    WideNode& node = kept.node(root + i);
    const Box* boxes[WideNode::kWidth];
    Box all = Box::Empty();
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      boxes[k] = child.IsSubset() ? &plan.subsets[child.number()].bounds
                                  : &plan.node_bounds[child.number() - root];
      all.Extend(boxes[k]->lower);
      all.Extend(boxes[k]->upper);
    }
    EncodeChildren(boxes, node.count, node);
    plan.node_bounds[i] = all;
  }
  return plan.node_bounds[0];
}

inline void Refit(KeptPartition& kept, const MeshTable& now, RefitPlan& plan) {
  kept.MoveTo(now, plan.bounds);
  const size_t count = plan.subsets.size();
  for (size_t piece = 0; piece < plan.pieces.size(); ++piece) {
    const WideNode* from = plan.pieces[piece].nodes.data();
    const size_t begin = piece * RefitPlan::kPiece;
    for (size_t i = begin; i < std::min(count, begin + RefitPlan::kPiece); ++i) {
      Subset& subset = kept.subset(static_cast<uint32_t>(i));
      const RefittedSubset& refitted = plan.subsets[i];
      if (!refitted.is_unit) continue;
      subset.mesh_bits = refitted.mesh_bits;
      std::copy_n(refitted.bounds.lower, 3, subset.lower);
      std::copy_n(refitted.bounds.upper, 3, subset.upper);
      const uint32_t state = subset.root;
      if (!refitted.is_stale || state >= Subset::kNoRoom) continue;
      const uint32_t root = state & ~Subset::kStale;
      for (uint32_t k = 0; k < subset.node_count; ++k) {
        kept.node(root + k) = *from++;
        kept.node(root + k).SetLeavesStale();
      }
      subset.root = refitted.has_decayed && !plan.always ? root | Subset::kStale : root;
    }
  }
  const auto set_parent = [&](const Subset& subset, ChildWord word) {
    if (subset.parent == Subset::kNowhere) return;
    kept.node(subset.parent / WideNode::kWidth).SetChild(subset.parent % WideNode::kWidth, word);
  };
  // Subsets stand behind those that they are in.
  for (size_t i = count; i-- > 0;) {
    const Subset& subset = kept.subset(static_cast<uint32_t>(i));
    set_parent(subset, ChildWord::Subset(static_cast<uint32_t>(i)));
    if (!plan.subsets[i].is_unit) plan.subsets[i].bounds = RefitOver(kept, subset, plan);
  }
  for (size_t i = 0; i < count; ++i) {
    const Subset& subset = kept.subset(static_cast<uint32_t>(i));
    if (Subset::IsNode(subset.root)) set_parent(subset, ChildWord::Inner(subset.root));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_REFIT_INL_H_
