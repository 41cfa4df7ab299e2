// Which ranges of a binary partition become nodes of eight children: those that together have the
// least surface, by dynamic programming. What rays cost in leaves is the same for any choice.
// Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs",
// HPG 2017, section 3.1.

#if defined(DACRT_PARTITION_CHOOSE_NODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_CHOOSE_NODES_INL_H_
#undef DACRT_PARTITION_CHOOSE_NODES_INL_H_
#else
#define DACRT_PARTITION_CHOOSE_NODES_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "geometry/binary_range.h"
#include "geometry/sort_eight-inl.h"
#include "geometry/wide_node-inl.h"
#include "runtime/assert.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// What a range costs in up to 1, 2, ... 8 places of a node above it, a lane each, and how many
/// places its left half gets then; 0 where it stays whole, as a node of its own, which costs `own`.
inline void ChooseShares(BinaryRange* ranges, BinaryRange& range, float own) {
  constexpr size_t kWidth = WideNode::kWidth;
  constexpr float kNever = std::numeric_limits<float>::infinity();
  const BinaryRange& left = ranges[range.first];
  HWY_ALIGN float right[2 * kWidth];  // in less than one place: never
  for (size_t part = 0; part < kParts; ++part) {
    const size_t lane = part * kPartLanes;
    hn::Store(hn::Set(kEightTag, kNever), kEightTag, right + lane);
    hn::Store(hn::LoadU(kEightTag, ranges[range.first + 1].cost + lane), kEightTag,
              right + kWidth + lane);
  }
  EightPart best[kParts], share[kParts];
  for (size_t part = 0; part < kParts; ++part) {
    best[part] = hn::Set(kEightTag, kNever);
    share[part] = hn::Set(kEightTag, 1.0f);
  }
  for (size_t places = 1; places < kWidth; ++places) {
    const EightPart of_left = hn::Set(kEightTag, left.cost[places - 1]);
    const EightPart number = hn::Set(kEightTag, static_cast<float>(places));
    for (size_t part = 0; part < kParts; ++part) {
      const EightPart of_right = hn::LoadU(kEightTag, right + kWidth + part * kPartLanes - places);
      const EightPart cost = hn::Add(of_left, of_right);
      share[part] = hn::IfThenElse(hn::Lt(cost, best[part]), number, share[part]);
      best[part] = hn::Min(cost, best[part]);
    }
  }
  HWY_ALIGN float all[kPartLanes];
  hn::Store(best[kParts - 1], kEightTag, all);
  const EightPart whole = hn::Set(kEightTag, own + all[kPartLanes - 1]);
  const hn::RebindToSigned<EightTag> di;
  const hn::Rebind<uint8_t, EightTag> d8;
  for (size_t part = 0; part < kParts; ++part) {
    const size_t lane = part * kPartLanes;
    const auto taken = hn::IfThenElseZero(hn::Not(hn::Lt(whole, best[part])), share[part]);
    hn::StoreU(hn::Min(whole, best[part]), kEightTag, range.cost + lane);
    hn::StoreU(hn::DemoteTo(d8, hn::ConvertTo(di, taken)), d8, range.left_places + lane);
  }
  // One place has nothing to share, also where surfaces are beyond all numbers and none is less.
  range.left_places[0] = 0;
}

/// Calls f(number) for each range of a partition, after it was called for its halves.
template <class F>
inline void ForEachUpwards(const BinaryRange* ranges, const F& f) {
  const auto first_below = [&](uint32_t number) {
    while (!ranges[number].IsLeaf()) number = ranges[number].first;
    return number;
  };
  for (uint32_t number = first_below(0);;) {
    f(number);
    if (number == 0) return;
    const uint32_t parent = ranges[number].parent;
    number = number == ranges[parent].first ? first_below(number + 1) : parent;
  }
}

/// Chooses for all ranges of a partition, the first of which is all of it.
inline void ChooseNodes(BinaryRange* ranges) {
  // Of nearly equal surfaces, and of ranges that have none, the one of fewer nodes.
  constexpr float kLeast = 0x1p-8f;
  ForEachUpwards(ranges, [&](uint32_t number) HWY_ATTR {
    BinaryRange& range = ranges[number];
    if (range.IsLeaf()) {
      range.leaf_surface = range.surface;
      std::fill_n(range.cost, WideNode::kWidth, 0.0f);
    } else {
      range.leaf_surface = ranges[range.first].leaf_surface + ranges[range.first + 1].leaf_surface;
      ChooseShares(ranges, range, range.surface + kLeast);
    }
  });
}

/// The children of the node that `range` is; of a leaf itself. Returns how many.
inline size_t ChildrenOf(const BinaryRange* ranges, uint32_t range, uint32_t* children) {
  struct Share {
    uint32_t range;
    uint32_t places;
  };
  Share open[WideNode::kWidth];
  size_t open_count = 0, count = 0;
  open[open_count++] = {range, WideNode::kWidth};
  while (open_count > 0) {
    const Share share = open[--open_count];
    const BinaryRange& next = ranges[share.range];
    const uint32_t left = next.IsLeaf() ? 0 : next.left_places[share.places - 1];
    if (left == 0) {
      children[count++] = share.range;
      continue;
    }
    open[open_count++] = {next.first + 1, share.places - left};
    open[open_count++] = {next.first, left};
  }
  DACRT_ASSERT(count <= WideNode::kWidth);
  return count;
}

/// Sorts the children of a node, of one of these ranges: large ones that hold little come first.
/// Rays that look for any hit visit them so; to the one that most rays enter they go before they
/// know that they do. Rays that look for the closest hit visit the last one first of those in which
/// they begin. Sponza took 267 ns a single shadow ray instead of 230 in the order in which space
/// was split, and 676 instead of 623 a diffuse ray in packets of 8 where the first one came first;
/// a terrain 143 and 119 a shadow ray. Nah, Manocha, "SATO: surface area traversal order for shadow
/// ray tracing", Computer Graphics Forum 33(6), 2014.
inline void SortChildren(const BinaryRange* ranges, uint32_t* children, size_t count) {
  constexpr size_t kWidth = WideNode::kWidth;
  constexpr float kMost = std::numeric_limits<float>::max();
  HWY_ALIGN float surfaces[kWidth], leaf_surfaces[kWidth];
  std::fill_n(surfaces, kWidth, 0.0f);
  std::fill_n(leaf_surfaces, kWidth, kMost);
  for (size_t i = 0; i < count; ++i) {
    const BinaryRange& range = ranges[children[i]];
    surfaces[i] = range.surface;
    leaf_surfaces[i] = range.leaf_surface;
  }
  EightPart keys[kParts];
  for (size_t part = 0; part < kParts; ++part) {
    const EightPart surface = hn::Load(kEightTag, surfaces + part * kPartLanes);
    const EightPart held = hn::Load(kEightTag, leaf_surfaces + part * kPartLanes);
    const EightPart key = hn::Div(held, hn::MulAdd(surface, surface, hn::Set(kEightTag, 0x1p-60f)));
    // Surfaces beyond all numbers, too, have a place.
    const EightPart most = hn::Set(kEightTag, kMost);
    keys[part] = hn::IfThenElse(hn::Lt(key, most), key, most);
  }
  uint8_t order[kWidth];
  SortEight(keys, order);
  uint32_t sorted[kWidth];
  size_t place = 0;
  for (const uint8_t i : order) {
    if (i < count) sorted[place++] = children[i];
  }
  std::copy_n(sorted, count, children);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_CHOOSE_NODES_INL_H_
