// From references to the nodes of the kept partition: a binary partition from the top down, whose
// ranges are put where they have less surface, and of them those become nodes that together have
// the least.

#if defined(DACRT_PARTITION_BUILD_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BUILD_NODES_INL_H_
#undef DACRT_PARTITION_BUILD_NODES_INL_H_
#else
#define DACRT_PARTITION_BUILD_NODES_INL_H_
#endif

#include <span>

#include "geometry/wide_node-inl.h"
#include "partition/choose_nodes-inl.h"
#include "partition/reinsert_ranges-inl.h"
#include "partition/surface_split-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Sets what stands behind the volumes of a new node.
inline void SetChildren(const ChildWord* words, size_t count, WideNode& node) {
  node.lock = 0;
  node.bare = 0;
  node.marks = 0;
  for (size_t i = 0; i < WideNode::kWidth; ++i) {
    const ChildWord word = i < count ? words[i] : ChildWord();
    node.child[i] = word.bits();
    node.bare |= static_cast<uint8_t>(word.IsRange() << i);
  }
}

/// Makes nodes over ranges of references. `Leaves` says when a range is one, and what stands behind
/// it:
///   bool IsLeaf(const WeighedRange&)
///   ChildWord Child(const BinaryRange&)    called once for each leaf
template <class Kind, class Leaves>
class NodeBuilder {
 public:
  NodeBuilder(const Kind& kind, const ReinsertionEffort& effort, TriangleRef* refs, Leaves& leaves,
              std::span<BinaryRange> ranges, std::span<ExactNode> nodes, SubsetScratch& scratch)
      : kind_(kind),
        effort_(effort),
        refs_(refs),
        leaves_(leaves),
        ranges_(ranges),
        nodes_(nodes),
        scratch_(scratch) {}

  /// Builds nodes over `all`, the root first, which refer to each other as InnerOfExact. Returns
  /// how many there are, 0 if there is not enough room.
  size_t Build(const WeighedRange& all) {
    const float scale = all.range.bounds.SurfaceScale();
    if (!SplitAll(all, scale)) return 0;
    Reinserter(ranges_.first(range_count_), scale).Run(effort_);
    ChooseNodes(ranges_.data());
    count_ = 1;
    return MakeNode(0, 0) ? count_ : 0;
  }

 private:
  /// The binary partition: a range stands before those that it is split into.
  bool SplitAll(const WeighedRange& all, float scale) {
    const auto keep = [&](uint32_t number, const WeighedRange& range, uint32_t parent) {
      BinaryRange& kept = ranges_[number];
      kept.bounds = range.range.bounds;
      kept.begin = static_cast<uint32_t>(range.range.begin);
      kept.end = static_cast<uint32_t>(range.range.end);
      kept.first = 0;
      kept.parent = parent;
      kept.surface = kept.bounds.HalfArea() * scale;
    };
    keep(0, all, 0);
    range_count_ = 1;
    OpenRanges open({all, 0});
    while (!open.is_empty()) {
      const OpenRange next = open.Take();
      if (leaves_.IsLeaf(next.range)) continue;
      if (range_count_ + 2 > ranges_.size()) return false;
      const WeighedChildren halves = SplitRange(kind_, refs_, next.range, scratch_);
      DACRT_ASSERT(halves.left.range.count() > 0 && halves.right.range.count() > 0);
      const auto first = static_cast<uint32_t>(range_count_);
      ranges_[next.number].first = first;
      keep(first, halves.left, next.number);
      keep(first + 1, halves.right, next.number);
      range_count_ += 2;
      open.Add({halves.left, first}, {halves.right, first + 1});
    }
    return true;
  }

  bool MakeNode(uint32_t range, size_t number) {
    uint32_t children[WideNode::kWidth];
    const size_t count = ChildrenOf(ranges_.data(), range, children);
    if (number >= nodes_.size()) return false;
    SortChildren(ranges_.data(), children, count);
    ExactNode& node = nodes_[number];
    node.is_exact = true;
    const Box* boxes[WideNode::kWidth];
    for (size_t i = 0; i < count; ++i) boxes[i] = &ranges_[children[i]].bounds;
    EncodeChildren(boxes, count, node);
    size_t inner = 0;
    ChildWord words[WideNode::kWidth];
    for (size_t i = 0; i < count; ++i) {
      const BinaryRange& child = ranges_[children[i]];
      words[i] = child.IsLeaf() ? leaves_.Child(child) : InnerOfExact(count_ + inner++);
    }
    SetChildren(words, count, node);
    size_t next = count_;
    count_ += inner;
    for (size_t i = 0; i < count; ++i) {
      if (!ranges_[children[i]].IsLeaf() && !MakeNode(children[i], next++)) return false;
    }
    return true;
  }

  const Kind kind_;
  const ReinsertionEffort effort_;
  TriangleRef* const refs_;
  Leaves& leaves_;
  const std::span<BinaryRange> ranges_;
  const std::span<ExactNode> nodes_;
  SubsetScratch& scratch_;
  size_t range_count_ = 0;
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_BUILD_NODES_INL_H_
