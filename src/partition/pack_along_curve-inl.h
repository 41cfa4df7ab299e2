// Packing along a curve: triangles that stand in the order of a Morton curve are cut into leaves,
// leaves, where nodes may be what they cost in a moment, into nodes, and so on up to the root, row
// by row; of all ways to cut a row into groups of up to eight the one of least surface is found by
// dynamic programming, in one pass.
// Kamel, Faloutsos, "On packing R-trees", CIKM 1993: packing, into groups that are full.

#if defined(DACRT_PARTITION_PACK_ALONG_CURVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_PACK_ALONG_CURVE_INL_H_
#undef DACRT_PARTITION_PACK_ALONG_CURVE_INL_H_
#else
#define DACRT_PARTITION_PACK_ALONG_CURVE_INL_H_
#endif

#include <bit>
#include <limits>
#include <span>
#include <type_traits>

#include "geometry/extent-inl.h"
#include "geometry/ray_box-inl.h"
#include "geometry/wide_node-inl.h"
#include "partition/build_nodes-inl.h"
#include "partition/weighed_range-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// The best way to cut a row of boxes, given one after the other, into groups of `fewest` to eight
/// that follow each other: the sum of half their surfaces, times `scale`, and of `each` for each of
/// them, is least. Where boxes have weights, those of a group are together at most eight.
template <bool kHasWeights>
class RowCut {
 public:
  RowCut(size_t fewest, float scale, float each) : scale_(scale), each_(each) {
    for (size_t k = 0; k < 2 * kMost; ++k) {
      too_few_[k] = k % kMost + fewest > kMost ? kNever : 0.0f;
    }
    for (size_t part = 0; part < kParts; ++part) {
      for (int axis = 0; axis < 3; ++axis) {
        lower_[part][axis] = upper_[part][axis] = hn::Zero(kEightTag);
      }
      before_[part] = hn::Set(kEightTag, kNever);
      weights_[part] = hn::Zero(kEightTag);
    }
    least_ = hn::Zero(kEightTag);
  }

  /// Returns how many there are in the group that ends with the box, if one does.
  template <class Corners>
  HWY_INLINE uint8_t Add(const Corners& box, size_t weight) {
    HWY_ALIGN static constexpr uint32_t kOne[2 * kMost] = {0, 0, 0, 0, 0, 0, 0, 0, ~0u};
    const size_t lane = count_++ % kMost;
    EightPart cost[kParts];
    EightPart best = hn::Set(kEightTag, kNever);
    for (size_t part = 0; part < kParts; ++part) {
      const size_t first = part * kPartLanes;
      const float* const one = reinterpret_cast<const float*>(kOne) + kMost - lane + first;
      const auto begins = hn::MaskFromVec(hn::LoadU(kEightTag, one));
      EightPart edge[3];
      for (int axis = 0; axis < 3; ++axis) {
        const EightPart low = hn::Set(kEightTag, box.lower[axis]);
        const EightPart high = hn::Set(kEightTag, box.upper[axis]);
        EightPart& lower = lower_[part][axis];
        EightPart& upper = upper_[part][axis];
        lower = hn::IfThenElse(begins, low, hn::Min(lower, low));
        upper = hn::IfThenElse(begins, high, hn::Max(upper, high));
        edge[axis] = hn::Sub(upper, lower);
      }
      before_[part] = hn::IfThenElse(begins, least_, before_[part]);
      const EightPart area =
          hn::MulAdd(edge[0], hn::Add(edge[1], edge[2]), hn::Mul(edge[1], edge[2]));
      const EightPart too_few = hn::LoadU(kEightTag, too_few_ + kMost - 1 - lane + first);
      const EightPart group =
          hn::MulAdd(area, hn::Set(kEightTag, scale_), hn::Set(kEightTag, each_));
      cost[part] = hn::Add(before_[part], hn::Add(group, too_few));
      if constexpr (kHasWeights) {
        const EightPart w = hn::Set(kEightTag, static_cast<float>(weight));
        weights_[part] = hn::IfThenElse(begins, w, hn::Add(weights_[part], w));
        const auto fits = hn::Le(weights_[part], hn::Set(kEightTag, static_cast<float>(kMost)));
        // A box that is too heavy for any group is one by itself.
        cost[part] = hn::IfThenElse(hn::Or(fits, begins), cost[part], hn::Set(kEightTag, kNever));
      }
      best = hn::Min(best, cost[part]);
    }
    least_ = hn::MinOfLanes(kEightTag, best);
    uint64_t is_best = 0;
    for (size_t part = 0; part < kParts; ++part) {
      is_best |= Bits(kEightTag, hn::Eq(cost[part], least_)) << (part * kPartLanes);
    }
    DACRT_ASSERT(is_best != 0);
    // The group that began first is in the next lane.
    const auto from_first = std::rotr(static_cast<uint8_t>(is_best), static_cast<int>(lane) + 1);
    const size_t size = kMost - static_cast<size_t>(std::countr_zero(from_first));
    return static_cast<uint8_t>(HWY_MIN(size, count_));
  }

 private:
  static constexpr size_t kMost = WideNode::kWidth;
  static constexpr float kNever = std::numeric_limits<float>::infinity();

  /// A lane for each of the last eight boxes: the group that begins there, and what all before it
  /// costs.
  EightPart lower_[kParts][3], upper_[kParts][3], before_[kParts], weights_[kParts];
  EightPart least_;  ///< what all that came so far costs, in all lanes
  float scale_, each_;
  size_t count_ = 0;
  HWY_ALIGN float too_few_[2 * kMost];
};

/// Cuts a row of boxes with the weights that `kind` says. Writes for each how many there are in the
/// group that ends with it. Another group costs, beside its surface, what a full one does: with
/// half of that or twice as much rays take up to 3 % longer in one scene or another.
template <class Kind, class Corners>
inline void CutRow(const Kind& kind, std::span<const Corners> boxes, size_t fewest, float scale,
                   uint8_t* sizes) {
  constexpr bool kHasWeights = std::is_same_v<Kind, Items>;
  // In two halves side by side: a step waits for the one before.
  const size_t middle = boxes.size() / 2;
  const float each = static_cast<float>(WideNode::kWidth) / static_cast<float>(boxes.size());
  RowCut<kHasWeights> left(fewest, scale, each), right(fewest, scale, each);
  const auto add = [&](RowCut<kHasWeights>& row, size_t i) HWY_ATTR {
    size_t weight = 1;
    if constexpr (kHasWeights) weight = kind.Weight(boxes[i]);
    sizes[i] = row.Add(boxes[i], weight);
  };
  for (size_t i = 0; i < middle; ++i) {
    add(left, i);
    add(right, middle + i);
  }
  if (boxes.size() % 2 != 0) add(right, boxes.size() - 1);
}

/// Makes the groups of a row that begins with number `first`. Returns how many there are.
template <class Corners>
inline size_t JoinGroups(std::span<const Corners> boxes, size_t first, const uint8_t* sizes,
                         PackedRange* groups) {
  size_t count = 0;
  for (size_t end = boxes.size(); end > 0; end -= sizes[end - 1]) ++count;
  size_t number = count;
  for (size_t end = boxes.size(), begin; end > 0; end = begin) {
    begin = end - sizes[end - 1];
    Extent extent = Extent::Of(boxes[begin]);
    for (size_t i = begin + 1; i < end; ++i) extent.Join(Extent::Of(boxes[i]));
    PackedRange& group = groups[--number];
    extent.Put(group);
    group.begin = static_cast<uint32_t>(first + begin);
    group.end = static_cast<uint32_t>(first + end);
  }
  return count;
}

/// Makes nodes of what has been packed, of which the first `leaf_count` are leaves, and the last is
/// the root: that comes first. Returns how many there are.
template <class Leaves>
inline size_t MakePackedNodes(std::span<const PackedRange> packed, size_t leaf_count,
                              Leaves& leaves, ExactNode* nodes) {
  const size_t last = packed.size() - 1, count = packed.size() - leaf_count;
  DACRT_ASSERT(count <= SubsetScratch::kNodes);
  for (size_t number = 0; number < count; ++number) {
    const PackedRange& group = packed[last - number];
    const size_t children = group.end - group.begin;
    ChildBoxes boxes;
    ChildWord words[WideNode::kWidth];
    for (size_t k = 0; k < children; ++k) {
      const size_t child = group.begin + k;
      boxes.Set(k, packed[child]);
      words[k] = child < leaf_count ? leaves.Child(packed[child].begin, packed[child].end)
                                    : InnerOfExact(last - child);
    }
    nodes[number].is_exact = true;
    boxes.Encode(children, nodes[number]);
    SetChildren(words, children, nodes[number]);
  }
  return count;
}

/// Cuts the triangles of `range`, which begins with scratch.refs and stands in the order of the
/// curve, into leaves. They are the first of scratch.packed; returns how many there are.
template <class Kind>
inline size_t PackLeaves(const Kind& kind, const TriangleRange& range, SubsetScratch& scratch) {
  const std::span<const TriangleRef> refs(scratch.refs, range.count());
  CutRow(kind, refs, 1, range.bounds.SurfaceScale(), scratch.sizes);
  return JoinGroups(refs, 0, scratch.sizes, scratch.packed);
}

/// Makes nodes over the leaves that are the first of scratch.packed, the root first. Returns how
/// many there are.
template <class Leaves>
inline size_t PackNodes(const Box& bounds, size_t leaf_count, Leaves& leaves,
                        SubsetScratch& scratch) {
  // Nodes have so many children at least: there is room for them then.
  constexpr size_t kFewest = 4;
  static_assert(SubsetScratch::kTriangles / (kFewest - 1) <= SubsetScratch::kNodes);
  PackedRange* const packed = scratch.packed;
  uint8_t* const sizes = scratch.sizes;
  size_t first = 0, count = leaf_count;
  do {
    const std::span<const PackedRange> row(packed + first, count);
    if (count <= WideNode::kWidth) {
      sizes[count - 1] = static_cast<uint8_t>(count);
    } else {
      CutRow(Triangles(), row, kFewest, bounds.SurfaceScale(), sizes);
    }
    first += count;
    count = JoinGroups(row, first - count, sizes, packed + first);
  } while (count > 1);
  return MakePackedNodes({packed, first + 1}, leaf_count, leaves, scratch.nodes);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_PACK_ALONG_CURVE_INL_H_
