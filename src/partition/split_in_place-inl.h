// Splitting a large subset of the kept partition where there is no memory for a grid: its numbers
// are partitioned where they stand, at the middle of the centres, into eight smaller subsets.

#if defined(DACRT_PARTITION_SPLIT_IN_PLACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SPLIT_IN_PLACE_INL_H_
#undef DACRT_PARTITION_SPLIT_IN_PLACE_INL_H_
#else
#define DACRT_PARTITION_SPLIT_IN_PLACE_INL_H_
#endif

#include <algorithm>
#include <span>

#include "partition/split_subset-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Bounds of some triangles, and of their centres.
struct NumberBounds {
  Box triangles;
  Box centers;
};

inline NumberBounds BoundNumbers(const GeometryTable& geometries,
                                 std::span<const uint32_t> numbers) {
  CornerBounds triangles, centers;
  TriangleFinder finder(geometries);
  for (const uint32_t number : numbers) {
    const auto [lower, upper] = finder.BoundUsable(number);
    triangles.Extend(lower, upper);
    centers.Extend(TwiceCenter(lower, upper));
  }
  return {triangles.Get(), centers.Get()};
}

/// Moves the triangles of the lower half of space before the others, and returns how many they are;
/// half of them, as they stand, where that leaves one side empty.
inline size_t HalveNumbers(const GeometryTable& geometries, std::span<uint32_t> numbers) {
  const Box centers = BoundNumbers(geometries, numbers).centers;
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (centers.upper[i] - centers.lower[i] > centers.upper[axis] - centers.lower[axis]) axis = i;
  }
  const BinMap halves(centers, 2);
  TriangleFinder finder(geometries);
  const auto middle = std::partition(numbers.begin(), numbers.end(), [&](uint32_t number) HWY_ATTR {
    const auto [lower, upper] = finder.BoundUsable(number);
    HWY_ALIGN int32_t half[4];
    halves.Map(TwiceCenter(lower, upper), half);
    return half[axis] == 0;
  });
  const bool is_split = middle != numbers.begin() && middle != numbers.end();
  return is_split ? static_cast<size_t>(middle - numbers.begin()) : numbers.size() / 2;
}

/// For subsets of at least WideNode::kWidth triangles. Returns the number of the root, which is the
/// only node, or Subset::kNoRoom. Takes no memory but that of the partition.
inline uint32_t SplitInPlace(KeptPartition& kept, Subset& subset) {
  const GeometryTable& geometries = kept.geometries();
  std::span<uint32_t> children[WideNode::kWidth];
  children[0] = kept.OrderOf(subset);
  for (size_t count = 1; count < WideNode::kWidth; ++count) {
    auto& largest = *std::max_element(children, children + count, [](const auto& a, const auto& b) {
      return a.size() < b.size();
    });
    const size_t lower = HalveNumbers(geometries, largest);
    DACRT_ASSERT(lower > 0 && lower < largest.size());
    children[count] = largest.subspan(lower);
    largest = largest.first(lower);
  }
  ExactNode node{};
  node.is_exact = true;
  Box bounds[WideNode::kWidth];
  const Box* boxes[WideNode::kWidth];
  for (uint32_t i = 0; i < WideNode::kWidth; ++i) {
    bounds[i] = BoundNumbers(geometries, children[i]).triangles;
    boxes[i] = &bounds[i];
    node.child[i] = ChildWord::Subset(i).bits();
  }
  EncodeChildren(boxes, WideNode::kWidth, node);
  uint32_t first_subset;
  const auto nodes = KeepNodes(kept, {&node, 1}, WideNode::kWidth, first_subset);
  if (!nodes) return Subset::kNoRoom;
  subset.node_slots = nodes->count;
  for (uint32_t i = 0; i < WideNode::kWidth; ++i) {
    Subset& child = kept.subset(first_subset + i);
    child.SetUnsplit(static_cast<uint32_t>(children[i].data() - kept.triangles().data()),
                     static_cast<uint32_t>(children[i].size()), bounds[i].HalfArea());
  }
  return nodes->first;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_IN_PLACE_INL_H_
