// Splitting along a curve: triangles that stand in the order of a Morton curve stay where they are,
// and the surface area heuristic chooses among the places where the curve enters another cell.
// Lauterbach, Garland, Sengupta, Luebke, Manocha, "Fast BVH construction on GPUs", Eurographics
// 2009, with the surface area heuristic at the other end of the hierarchy: large ranges, of which
// every level costs the same, are split along the curve, and small ones, where most of the nodes
// are, may be split on three axes.

#if defined(DACRT_PARTITION_SPLIT_ALONG_CURVE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_SPLIT_ALONG_CURVE_INL_H_
#undef DACRT_PARTITION_SPLIT_ALONG_CURVE_INL_H_
#else
#define DACRT_PARTITION_SPLIT_ALONG_CURVE_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <limits>

#include "partition/sort_along_curve-inl.h"
#include "partition/surface_split-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Triangles that stand in the order of a curve.
struct AlongCurve : Triangles {
  const uint32_t* codes;  ///< the cell of each, above kNumberBits bits of something else
  /// Ranges of at most so many triangles are split on three axes, and ordered anew.
  size_t by_surface;
};

/// The best split of a range of at least two references by the surfaces of its sides.
inline WeighedChildren SplitRange(const AlongCurve& curve, TriangleRef* refs,
                                  const WeighedRange& parent, SubsetScratch& scratch) {
  if (parent.range.count() <= curve.by_surface) {
    const TriangleRange& range = parent.range;
    // Where the centres lie is not known of what was split along the curve.
    const bool is_measured = !range.centers.IsEmpty();
    return SplitRange<Triangles>(
        curve, refs,
        {is_measured ? range : MeasureTriangles(refs, range.begin, range.end), parent.weight},
        scratch);
  }
  // The range in parts between which it may be split: single triangles of a few, cells of many.
  constexpr size_t kMostParts = 16;
  const size_t begin = parent.range.begin, count = parent.range.count();
  Extent::Floats extents[kMostParts];
  size_t ends[kMostParts];
  size_t parts = 0;
  if (count <= kMostParts) {
    for (; parts < count; ++parts) {
      Extent::Of(refs[begin + parts]).Store(extents[parts]);
      ends[parts] = parts + 1;
    }
  } else {
    const uint32_t* const codes = curve.codes + begin;
    const uint32_t apart = (codes[0] ^ codes[count - 1]) >> kNumberBits;
    // The three highest bits in which codes differ make eight cells. Where all are in one, any
    // eight parts will do.
    const auto bits = static_cast<uint32_t>(std::bit_width(apart));
    const uint32_t shift = kNumberBits + (bits > 3 ? bits - 3 : 0);
    const size_t most = apart == 0 ? (count + 7) / 8 : count;
    for (size_t i = 0; i < count;) {
      const uint32_t cell = codes[i] >> shift;
      const size_t end = std::min(i + most, count);
      Extent extent = Extent::Empty();
      do {
        extent.Join(Extent::Of(refs[begin + i]));
        ++i;
      } while (i < end && codes[i] >> shift == cell);
      extent.Store(extents[parts]);
      ends[parts++] = i;
    }
  }
  DACRT_ASSERT(parts >= 2 && parts <= kMostParts);

  float right_cost[kMostParts];
  Extent side = Extent::Empty();
  for (size_t k = parts - 1; k > 0; --k) {
    side.Join(Extent::Load(extents[k]));
    right_cost[k] = side.HalfArea() * LeafTests(count - ends[k - 1]);
  }
  side = Extent::Empty();
  float best_cost = std::numeric_limits<float>::infinity();
  size_t best = 0, best_larger = SIZE_MAX;
  Extent left = Extent::Empty();
  for (size_t k = 0; k + 1 < parts; ++k) {
    side.Join(Extent::Load(extents[k]));
    const size_t larger = std::max(ends[k], count - ends[k]);
    // What fits two leaves does not become three: nodes have only so much room.
    if (count <= 2 * kLeafLanes && larger > kLeafLanes) continue;
    const float cost = side.HalfArea() * LeafTests(ends[k]) + right_cost[k + 1];
    // Volumes that are all flat say nothing: then sides should be even.
    if (cost > best_cost || (cost == best_cost && larger >= best_larger)) continue;
    best_cost = cost;
    best_larger = larger;
    best = k;
    left = side;
  }
  Extent right = Extent::Empty();
  for (size_t k = best + 1; k < parts; ++k) right.Join(Extent::Load(extents[k]));
  const size_t middle = begin + ends[best];
  return {{{begin, middle, left.Get(), Box::Empty()}, ends[best]},
          {{middle, parent.range.end, right.Get(), Box::Empty()}, count - ends[best]}};
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PARTITION_SPLIT_ALONG_CURVE_INL_H_
