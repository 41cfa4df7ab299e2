// Space partition: a plane cuts the volume, and triangles that straddle it go to both sides,
// clipped. Mora, "Naive ray-tracing: a divide-and-conquer approach", ACM TOG 30(5), 2011; the plane
// is chosen by the surface area heuristic over bins, as for objects.

#if defined(DACRT_PAPER_CUT_SPACE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_CUT_SPACE_INL_H_
#undef DACRT_PAPER_CUT_SPACE_INL_H_
#else
#define DACRT_PAPER_CUT_SPACE_INL_H_
#endif

#include <algorithm>
#include <optional>
#include <span>

#include "geometry/corner-inl.h"
#include "paper/binning-inl.h"
#include "paper/split_cost.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A plane: bins 0 to last_left_bin of `axis` lie before it. The counts of the sides add up to more
/// than the triangles by those that straddle it.
struct Cut {
  BinMap map;
  int axis;
  int32_t last_left_bin;
  float plane;
  size_t left_count;
  size_t right_count;
};

/// Counts in which bins the triangles begin and end.
inline void BinEnds(const TriangleRef* refs, const TriangleRange& triangles, const BinMap& map,
                    Scratch& scratch) {
  std::fill_n(&scratch.begins[0][0], 3 * Scratch::kMaxBins, 0);
  std::fill_n(&scratch.ends[0][0], 3 * Scratch::kMaxBins, 0);
  for (size_t i = triangles.begin; i < triangles.end; ++i) {
    HWY_ALIGN int32_t first[4], last[4];
    map.Map(Corner::Load(refs[i].lower), first);
    map.Map(Corner::Load(refs[i].upper), last);
    for (int axis = 0; axis < 3; ++axis) {
      ++scratch.begins[axis][first[axis]];
      ++scratch.ends[axis][last[axis]];
    }
  }
}

/// The cut of least cost; nothing if none leaves fewer triangles to test than there are.
inline std::optional<Cut> ChooseCut(const TriangleRef* refs, const TriangleRange& triangles,
                                    uint32_t bins, Scratch& scratch) {
  const Box& bounds = triangles.bounds;
  const double area = bounds.HalfArea();
  if (!(area > 0)) return std::nullopt;
  const BinMap map(bounds, bins);
  BinEnds(refs, triangles, map, scratch);
  std::optional<Cut> best;
  double best_cost = static_cast<double>(triangles.count());
  for (int axis = 0; axis < 3; ++axis) {
    if (!map.IsUseful(axis)) continue;
    size_t left = 0, right = triangles.count();
    for (uint32_t k = 0; k + 1 < bins; ++k) {
      left += scratch.begins[axis][k];
      right -= scratch.ends[axis][k];
      if (left == triangles.count() || right == triangles.count()) continue;
      Box left_box = bounds, right_box = bounds;
      left_box.upper[axis] = right_box.lower[axis] = map.Boundary(axis, k);
      const double cost =
          SplitCost(left_box.HalfArea() / area, left, right_box.HalfArea() / area, right);
      if (cost >= best_cost) continue;
      best_cost = cost;
      best = Cut{map, axis, static_cast<int32_t>(k), right_box.lower[axis], left, right};
    }
  }
  return best;
}

/// Reorders refs[triangles] into those before the plane, those on both sides, and those behind it.
/// Returns where the second and the third begin.
inline std::pair<size_t, size_t> SortBySide(TriangleRef* refs, const TriangleRange& triangles,
                                            const Cut& cut) {
  size_t left_end = triangles.begin, right_begin = triangles.end;
  for (size_t i = left_end; i < right_begin;) {
    HWY_ALIGN int32_t first[4], last[4];
    cut.map.Map(Corner::Load(refs[i].lower), first);
    cut.map.Map(Corner::Load(refs[i].upper), last);
    if (last[cut.axis] <= cut.last_left_bin) {
      std::swap(refs[i++], refs[left_end++]);
    } else if (first[cut.axis] > cut.last_left_bin) {
      std::swap(refs[i], refs[--right_begin]);
    } else {
      ++i;
    }
  }
  return {left_end, right_begin};
}

/// Keeps of references that straddle a plane what lies before it, or behind it. Rounding may have
/// put the plane beside a triangle that straddles it by its bins; no box is turned inside out for
/// that.
inline void ClipTriangles(std::span<TriangleRef> refs, int axis, float plane, bool before) {
  for (TriangleRef& ref : refs) {
    float& face = before ? ref.upper[axis] : ref.lower[axis];
    face = std::clamp(plane, ref.lower[axis], ref.upper[axis]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_CUT_SPACE_INL_H_
