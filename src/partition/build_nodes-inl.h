// From references to the nodes of the kept partition, from the top down.

#if defined(DACRT_PARTITION_BUILD_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BUILD_NODES_INL_H_
#undef DACRT_PARTITION_BUILD_NODES_INL_H_
#else
#define DACRT_PARTITION_BUILD_NODES_INL_H_
#endif

#include <algorithm>
#include <span>

#include "geometry/wide_node-inl.h"
#include "partition/surface_split-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The children of a node that is being made: a range of references each.
template <class Kind>
class Opening {
 public:
  explicit Opening(const WeighedRange& range) { children_[0] = range; }

  size_t count() const { return count_; }
  const WeighedRange& operator[](size_t i) const { return children_[i]; }

  /// Splits children of more than `most`, first those of the largest surface, until there are
  /// eight.
  void Open(const Kind& kind, TriangleRef* refs, size_t most, SubsetScratch& scratch) {
    while (count_ < WideNode::kWidth) {
      const size_t open = Largest(most, SIZE_MAX);
      if (open == count_) return;
      Split(open, kind, refs, scratch);
    }
  }

  /// Splits children that the places left suffice for, if their leaves are full, first those of the
  /// largest surface: each saves a node.
  void Dissolve(const Kind& kind, TriangleRef* refs, size_t most, SubsetScratch& scratch) {
    for (;;) {
      const size_t places = WideNode::kWidth - count_;
      const size_t open = Largest(most, (places + 1) * most);
      if (places == 0 || open == count_) return;
      Split(open, kind, refs, scratch);
    }
  }

  /// Writes the volumes of a node; what stands behind them is left to do.
  void Encode(WideNode& node) const {
    const Box* boxes[WideNode::kWidth];
    for (size_t i = 0; i < count_; ++i) boxes[i] = &children_[i].range.bounds;
    EncodeChildren(boxes, count_, node);
  }

 private:
  void Split(size_t open, const Kind& kind, TriangleRef* refs, SubsetScratch& scratch) {
    const WeighedChildren halves = SplitRange(kind, refs, children_[open], scratch);
    std::copy_backward(children_ + open + 1, children_ + count_, children_ + count_ + 1);
    DACRT_ASSERT(halves.left.range.count() > 0 && halves.right.range.count() > 0);
    children_[open] = halves.left;
    children_[open + 1] = halves.right;
    ++count_;
  }

  /// The child with the largest surface among those of more than `above` and at most `most`;
  /// count() if there is none.
  size_t Largest(size_t above, size_t most) const {
    size_t largest = count_;
    float largest_area = -1;
    for (size_t i = 0; i < count_; ++i) {
      const WeighedRange& child = children_[i];
      if (child.weight <= above || child.weight > most || child.range.count() < 2) continue;
      const float area = child.range.bounds.HalfArea();
      if (area <= largest_area) continue;
      largest_area = area;
      largest = i;
    }
    return largest;
  }

  WeighedRange children_[WideNode::kWidth];
  size_t count_ = 1;
};

/// Makes nodes over ranges of references. `Leaves` says when a child is one, and what stands behind
/// it:
///   size_t most()                           weight of a leaf
///   size_t most_of_node()                   weight up to which one node nearly always suffices
///   bool IsLeaf(const WeighedRange&)
///   ChildWord Child(const WeighedRange&)    called once for each leaf
template <class Kind, class Leaves>
class NodeBuilder {
 public:
  NodeBuilder(const Kind& kind, TriangleRef* refs, Leaves& leaves, std::span<WideNode> nodes,
              SubsetScratch& scratch)
      : kind_(kind), refs_(refs), leaves_(leaves), nodes_(nodes), scratch_(scratch) {}

  /// Builds nodes over `range`, the root first; their numbers count from there. Returns how many
  /// there are, 0 if there is not enough room.
  size_t Build(const WeighedRange& range) {
    count_ = 1;
    return BuildNode(range, 0) ? count_ : 0;
  }

 private:
  bool BuildNode(const WeighedRange& range, size_t number) {
    Opening<Kind> children(range);
    // What fits a node of its own is not taken apart for a larger one: that would leave both half
    // empty.
    if (range.weight > leaves_.most_of_node()) {
      children.Open(kind_, refs_, leaves_.most_of_node(), scratch_);
    }
    if (children.count() == 1) {
      children.Open(kind_, refs_, leaves_.most(), scratch_);
    } else {
      children.Dissolve(kind_, refs_, leaves_.most(), scratch_);
    }
    DACRT_ASSERT(number < nodes_.size());
    WideNode& node = nodes_[number];
    children.Encode(node);
    node.unused = 0;
    node.lock = 0;
    node.bare = 0;
    node.stale = 0;
    size_t inner = 0;
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      ChildWord word;
      if (i < children.count()) {
        word = leaves_.IsLeaf(children[i])
                   ? leaves_.Child(children[i])
                   : ChildWord::Inner(static_cast<uint32_t>(count_ + inner++));
      }
      node.child[i] = word.bits();
      node.bare |= static_cast<uint8_t>(word.IsLeaf() << i);
    }
    if (count_ + inner > nodes_.size()) return false;
    size_t next = count_;
    count_ += inner;
    for (size_t i = 0; i < children.count(); ++i) {
      if (!leaves_.IsLeaf(children[i]) && !BuildNode(children[i], next++)) return false;
    }
    return true;
  }

  const Kind kind_;
  TriangleRef* const refs_;
  Leaves& leaves_;
  const std::span<WideNode> nodes_;
  SubsetScratch& scratch_;
  size_t count_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_BUILD_NODES_INL_H_
