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
#include <bit>

#include "partition/insert_subset-inl.h"
#include "partition/refit.h"
#include "partition/refit_subset-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Where triangles are that have moved.
class ChangedTriangles {
 public:
  ChangedTriangles(const KeptPartition& kept, const GeometryTable& geometries,
                   const std::vector<bool>& changed) {
    for (uint32_t geometry = 0; geometry < changed.size(); ++geometry) {
      if (!changed[geometry]) continue;
      bits_ |= kept.BitOf(geometry);
      if (rows_++ < kMostRows) {
        first_[rows_ - 1] = geometries.Number(geometry, 0);
        count_[rows_ - 1] = static_cast<uint32_t>(geometries[geometry].triangle_count);
      }
    }
  }

  /// Whether there are surely none in a subset.
  bool CannotBeIn(const Subset& subset) const {
    return subset.geometry_bits != 0 && !(subset.geometry_bits & bits_);
  }

  /// Whether there are some, or may be: by a look at its triangles, which costs little where few
  /// geometries have changed.
  bool AreIn(const KeptPartition& kept, const Subset& subset) const {
    if (CannotBeIn(subset)) return false;
    if (subset.geometry_bits == 0 || rows_ > kMostRows) return true;
    for (const uint32_t entry : kept.OrderOf(subset)) {
      const uint32_t number = KeptOrder::NumberOf(entry);
      for (size_t row = 0; row < rows_; ++row) {
        if (number - first_[row] < count_[row]) return true;
      }
    }
    return false;
  }

 private:
  static constexpr size_t kMostRows = 4;
  size_t rows_ = 0;
  uint32_t first_[kMostRows], count_[kMostRows];  ///< numbers of triangles
  uint64_t bits_ = 0;
};

/// The largest of `rows` rows of three words, `stride` bytes apart, without the bits that `mask`
/// leaves out.
inline uint32_t LargestWord(const void* rows_begin, size_t rows, size_t stride, uint32_t mask) {
  const auto* const begin = static_cast<const char*>(rows_begin);
  constexpr size_t kRow = 3 * sizeof(uint32_t);
  const hn::ScalableTag<uint32_t> du;
  const size_t lanes = hn::Lanes(du);
  auto most = hn::Zero(du);
  uint32_t largest = 0;
  size_t row = 0;
  if (stride == kRow) {
    // Three vectors are as many rows as there are lanes.
    for (; row + lanes <= rows; row += lanes) {
      const auto* const words = reinterpret_cast<const uint32_t*>(begin + row * kRow);
      for (size_t i = 0; i < 3; ++i)
        most = hn::Max(most, hn::And(hn::LoadU(du, words + i * lanes), hn::Set(du, mask)));
    }
    largest = hn::GetLane(hn::MaxOfLanes(du, most));
  }
  for (; row < rows; ++row) {
    uint32_t words[3];
    memcpy(words, begin + row * stride, sizeof(words));
    for (const uint32_t word : words) largest = HWY_MAX(largest, word & mask);
  }
  return largest;
}

/// Whether all triangles of a geometry can be hit, as far as its arrays say, each read once from
/// one end to the other: coordinates that no triangle uses count, too.
inline bool AllCanBeHit(const TriangleMesh& mesh) {
  constexpr uint32_t kNoSign = 0x7FFFFFFFu;  // the larger the number, the larger are its bits
  if (LargestWord(mesh.vertices, mesh.vertex_count, mesh.vertex_stride, kNoSign) >
      std::bit_cast<uint32_t>(kLargestCoordinate)) {
    return false;
  }
  return LargestWord(mesh.triangles, mesh.triangle_count, mesh.triangle_stride, UINT32_MAX) <
         mesh.vertex_count;
}

/// Whether the same items of a geometry can be hit as when the partition was made; `left_out` of
/// them could not, and still cannot.
inline bool SameCanBeHit(const GeometryTable& now, uint32_t geometry, size_t left_out) {
  if (left_out == 0 && now.HasTriangles(geometry) && AllCanBeHit(now[geometry])) return true;
  size_t count = 0;
  const CornerSource source(now, geometry);
  for (uint32_t primitive = 0; primitive < now[geometry].triangle_count; ++primitive) {
    CornerBox box;
    count += !BoundIfUsable(now, source, {geometry, primitive}, box);
  }
  return count == left_out;
}

inline bool SameCanBeHit(const KeptPartition& kept, const GeometryTable& now,
                         const std::vector<bool>& changed, TaskPool& tasks) {
  std::vector<size_t> left_out(changed.size());
  for (const uint32_t number : kept.left_out()) {
    CornerBox box;
    const GeometryTable::Name name = now.Locate(number);
    if (BoundIfUsable(now, name, box)) return false;
    ++left_out[name.geometry];
  }
  std::vector<uint32_t> geometries;
  size_t items = 0;
  for (uint32_t geometry = 0; geometry < changed.size(); ++geometry) {
    if (!changed[geometry] || now.shapes().IsHidden(geometry)) continue;
    geometries.push_back(geometry);
    items += now[geometry].triangle_count;
  }
  std::atomic<bool> is_same{true};
  const auto look_at = [&](size_t i) {
    if (is_same && !SameCanBeHit(now, geometries[i], left_out[geometries[i]])) is_same = false;
  };
  constexpr size_t kFewItems = 16384;  // some ten microseconds: less than to wake threads
  if (items > kFewItems) {
    tasks.ForEach(geometries.size(), look_at);
  } else {
    for (size_t i = 0; i < geometries.size(); ++i) look_at(i);
  }
  return is_same;
}

/// About the bounds that a subset will have: those of some of its triangles, or what is known.
inline Box EstimateBounds(const KeptPartition& kept, const GeometryTable& now, const Subset& subset,
                          const ChangedTriangles& changed) {
  if (changed.CannotBeIn(subset)) return subset.bounds();
  constexpr size_t kLooks = 16;
  const auto order = kept.OrderOf(subset);
  const size_t looks = HWY_MIN(kLooks, order.size());
  CornerBounds bounds;
  for (size_t i = 0; i < looks; ++i) {
    const uint32_t number = KeptOrder::NumberOf(order[i * order.size() / looks]);
    CornerBox box;
    if (BoundIfUsable(now, now.Locate(number), box)) bounds.Extend(box.lower, box.upper);
  }
  return bounds.Get();
}

/// Whether the subsets have grown, relative to the whole, so much that rays would come to too many
/// of them.
inline bool HaveDecayed(const KeptPartition& kept, const GeometryTable& now,
                        const ChangedTriangles& changed) {
  Box all = Box::Empty();
  float surface = 0, made_surface = 0;
  for (uint32_t i = 0; i < kept.subset_count(); ++i) {
    const Subset& subset = kept.subset(i);
    if (!IsUnit(subset)) continue;
    const Box bounds = EstimateBounds(kept, now, subset, changed);
    surface += bounds.HalfArea();
    made_surface += subset.made_surface;
    if (bounds.IsEmpty()) continue;
    all.Extend(bounds);
  }
  const float made_all = kept.subset(0).made_surface;
  return surface * made_all > refit::kMostDecay * made_surface * all.HalfArea();
}

inline bool CanRefit(const KeptPartition& kept, const GeometryTable& now, const RefitPlan& plan,
                     TaskPool& tasks) {
  if (kept.triangle_count() == 0 || kept.subset(0).root == Subset::kUnsplit) return false;
  if (kept.IsWornOut() && !plan.always) return false;
  return SameCanBeHit(kept, now, plan.changed, tasks) &&
         (plan.always || !HaveDecayed(kept, now, ChangedTriangles(kept, now, plan.changed)));
}

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
