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

/// The children of a node that is being made: a range of references each, and between them gaps,
/// ranked by the order in which they came about.
template <class Items>
class Opening {
 public:
  explicit Opening(const WeighedRange& range) { children_[0] = range; }

  size_t count() const { return count_; }
  const WeighedRange& operator[](size_t i) const { return children_[i]; }

  /// Splits children of more than `most` triangles, first those of the largest surface, until there
  /// are eight.
  void Open(TriangleRef* refs, size_t most, SubsetScratch& scratch) {
    while (count_ < WideNode::kWidth) {
      const size_t open = Largest(most);
      if (open == count_) return;
      const WeighedChildren halves = SplitBySurface<Items>(refs, children_[open], scratch);
      std::copy_backward(children_ + open + 1, children_ + count_, children_ + count_ + 1);
      std::copy_backward(ranks_ + open, ranks_ + count_ - 1, ranks_ + count_);
      children_[open] = halves.left;
      children_[open + 1] = halves.right;
      ranks_[open] = static_cast<uint8_t>(count_ - 1);
      ++count_;
    }
  }

  /// Writes the volumes and the gaps of a node; what stands in the children's places is left to do.
  void Encode(const Box& bounds, WideNode& node) const {
    const Box* boxes[WideNode::kWidth];
    for (size_t i = 0; i < count_; ++i) boxes[i] = &children_[i].range.bounds;
    EncodeChildren(bounds, boxes, count_, node);
    node.gaps = 0;
    for (size_t i = 0; i + 1 < count_; ++i) node.gaps |= uint32_t{ranks_[i]} << (3 * i);
  }

 private:
  /// The child with the largest surface among those of more than `weight` triangles; count() if
  /// there is none.
  size_t Largest(size_t weight) const {
    size_t largest = count_;
    float largest_area = -1;
    for (size_t i = 0; i < count_; ++i) {
      const WeighedRange& child = children_[i];
      if (child.weight <= weight || child.range.count() < 2) continue;
      const float area = child.range.bounds.HalfArea();
      if (area <= largest_area) continue;
      largest_area = area;
      largest = i;
    }
    return largest;
  }

  WeighedRange children_[WideNode::kWidth];
  uint8_t ranks_[WideNode::kWidth] = {};
  size_t count_ = 1;
};

/// Makes nodes over ranges of references. `Leaves` says when a child is one, and what stands in its
/// place:
///   size_t most()                           as for Opening::Open
///   bool IsLeaf(const WeighedRange&)
///   uint16_t Child(const WeighedRange&)     called for the leaves of a node one after the other
///   uint32_t first_other()                  asked before a node's leaves are
template <class Items, class Leaves>
class NodeBuilder {
 public:
  NodeBuilder(TriangleRef* refs, Leaves& leaves, std::span<WideNode> nodes, SubsetScratch& scratch)
      : refs_(refs), leaves_(leaves), nodes_(nodes), scratch_(scratch) {}

  /// Builds nodes over `range`, the root first; their numbers count from there. Returns how many
  /// there are, 0 if there is not enough room.
  size_t Build(const WeighedRange& range) {
    count_ = 1;
    return BuildNode(range, 0) ? count_ : 0;
  }

 private:
  bool BuildNode(const WeighedRange& range, size_t number) {
    Opening<Items> children(range);
    children.Open(refs_, leaves_.most(), scratch_);
    WideNode& node = nodes_[number];
    children.Encode(range.range.bounds, node);
    node.first_node = static_cast<uint32_t>(count_);
    node.first_other = leaves_.first_other();
    size_t inner = 0;
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      if (i >= children.count()) {
        node.child[i] = 0;
      } else if (leaves_.IsLeaf(children[i])) {
        node.child[i] = leaves_.Child(children[i]);
      } else {
        node.child[i] = WideNode::Child(WideNode::kInner, inner++);
      }
    }
    if (count_ + inner > nodes_.size()) return false;
    size_t next = count_;
    count_ += inner;
    for (size_t i = 0; i < children.count(); ++i) {
      if (!leaves_.IsLeaf(children[i]) && !BuildNode(children[i], next++)) return false;
    }
    return true;
  }

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
