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

#include "partition/can_refit-inl.h"
#include "partition/insert_subset-inl.h"
#include "partition/refit.h"
#include "partition/refit_subset-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The bounds of a subset that has no nodes.
inline Box BoundUnsplit(const KeptPartition& kept, Subset& subset) {
  const GeometryTable& geometries = kept.geometries();
  CornerBounds bounds;
  uint64_t geometry_bits = 0;
  uint32_t known = UINT32_MAX;
  ForEachReadAhead(geometries, kept.OrderOf(subset),
                   [&](size_t, GeometryTable::Name name, const CornerSource& source) HWY_ATTR {
                     Corner corners[3];
                     CornerBox box;
                     if (HWY_LIKELY(source.Load(name.primitive, corners))) {
                       for (const Corner& corner : corners) bounds.Extend(corner);
                     } else if (BoundIfUsable(geometries, source, name, box)) {
                       bounds.Extend(box.lower, box.upper);
                     }
                     if (HWY_LIKELY(name.geometry == known)) return;
                     known = name.geometry;
                     geometry_bits |= kept.BitOf(name.geometry);
                   });
  subset.geometry_bits = geometry_bits;
  return bounds.Get();
}

/// The bounds of one that has nodes, which are renewed.
inline Box RefitSplit(KeptPartition& kept, Subset& subset, const RefitPlan& plan) {
  const uint32_t before = subset.root, root = Subset::NodeOf(before);
  const NodeRun nodes{root, subset.node_slots};
  SubsetRefit refit(kept, subset, plan);
  const Box bounds = refit.Refit(root);
  subset.geometry_bits = refit.geometry_bits();
  const bool has_decayed =
      !plan.always && !refit.has_hidden() &&
      RelativeSurface(kept, nodes, bounds) > refit::kMostDecay * subset.decay_base;
  subset.root = has_decayed ? root | Subset::kStale : before & ~Subset::kStale;
  return bounds;
}

/// Refits a subset that has no others in it.
inline void RefitUnit(KeptPartition& kept, Subset& subset, const RefitPlan& plan) {
  const Box bounds =
      subset.root >= Subset::kNoRoom ? BoundUnsplit(kept, subset) : RefitSplit(kept, subset, plan);
  std::copy_n(bounds.lower, 3, subset.lower);
  std::copy_n(bounds.upper, 3, subset.upper);
}

/// New volumes for the nodes between a subset and the subsets in it. Returns its bounds.
class RefitOver {
 public:
  RefitOver(KeptPartition& kept) : kept_(kept) {}

  Box Subset(uint32_t number) {
    dacrt::Subset& subset = kept_.subset(number);
    return IsUnit(subset) ? subset.bounds() : Node(subset.root);
  }

 private:
  Box Node(uint32_t number) {
    WideNode& node = kept_.node(number);
    ChildBoxes boxes;
    Box all = Box::Empty();
    for (size_t k = 0; k < node.count; ++k) {
      const ChildWord child = node.Child(k);
      const Box box = child.IsSubset() ? Subset(child.number()) : Node(child.number());
      boxes.Set(k, box);
      if (box.IsEmpty()) continue;
      all.Extend(box);
    }
    boxes.FillEmpty(node.count);
    boxes.Encode(node.count, node);
    return all;
  }

  KeptPartition& kept_;
};

inline void Refit(KeptPartition& kept, const GeometryTable& now, const RefitPlan& plan,
                  TaskPool& tasks) noexcept {
  kept.SetGeometries(now);
  const ChangedTriangles changed(kept, now, plan.changed);
  const size_t count = kept.subset_count();
  constexpr size_t kPiece = 8;  // subsets: some thousand triangles
  const auto refit_piece = [&](size_t piece) {
    for (size_t i = piece * kPiece; i < HWY_MIN(count, (piece + 1) * kPiece); ++i) {
      Subset& subset = kept.subset(static_cast<uint32_t>(i));
      if (IsUnit(subset) && changed.AreIn(kept, subset)) RefitUnit(kept, subset, plan);
    }
  };
  const size_t pieces = (count + kPiece - 1) / kPiece;
  try {
    tasks.ForEach(pieces, refit_piece);
  } catch (...) {  // no memory for tasks
    for (size_t piece = 0; piece < pieces; ++piece) refit_piece(piece);
  }
  const auto set_parents = [&](bool as_subsets) {
    for (uint32_t i = 0; i < count; ++i) {
      const Subset& subset = kept.subset(i);
      if (subset.parent == Subset::kNowhere || !(as_subsets || Subset::IsNode(subset.root)))
        continue;
      kept.node(subset.parent / WideNode::kWidth)
          .SetChild(subset.parent % WideNode::kWidth,
                    as_subsets ? ChildWord::Subset(i) : ChildWord::Inner(subset.root));
    }
  };
  set_parents(true);
  if (const auto added = kept.TakeNew()) InsertSubset(kept, *added);
  kept.SetBounds(RefitOver(kept).Subset(0));
  set_parents(false);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_REFIT_INL_H_
