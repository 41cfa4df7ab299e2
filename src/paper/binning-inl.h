// Binning: the triangles of a subproblem counted by their centres, and the candidate partitions
// between the bins. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.
// Not what partition/surface_split-inl.h does with the same BinMap: here sample rays choose, so
// every candidate is kept with the boxes of both sides; there the first of least surface is all
// that is wanted.

#if defined(DACRT_PAPER_BINNING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_BINNING_INL_H_
#undef DACRT_PAPER_BINNING_INL_H_
#else
#define DACRT_PAPER_BINNING_INL_H_
#endif

#include "partition/bin_map-inl.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
/// Counts refs[begin, end) into scratch.bins.
inline void BinTriangles(const TriangleRef* refs, const TriangleRange& triangles, const BinMap& map,
                         uint32_t bins, Scratch& scratch) {
  for (auto& axis : scratch.bins) {
    for (uint32_t i = 0; i < bins; ++i) axis[i] = {Box::Empty(), 0};
  }
  for (size_t i = triangles.begin; i < triangles.end; ++i) {
    const Corner lower = Corner::Load(refs[i].lower), upper = Corner::Load(refs[i].upper);
    HWY_ALIGN int32_t number[4];
    map.Map(TwiceCenter(lower, upper), number);
    for (int axis = 0; axis < 3; ++axis) {
      Bin& bin = scratch.bins[axis][number[axis]];
      ExtendBox(bin.bounds, lower, upper);
      ++bin.count;
    }
  }
}

/// Candidate k of an axis has bins 0 to k on its left; fills scratch.candidates[axis][0 .. bins -
/// 2].
inline void MakeCandidates(uint32_t bins, Scratch& scratch) {
  for (int axis = 0; axis < 3; ++axis) {
    const Bin* bin = scratch.bins[axis];
    SplitCandidate* candidate = scratch.candidates[axis];
    Box box = Box::Empty();
    size_t count = 0;
    for (uint32_t k = 0; k + 1 < bins; ++k) {
      ExtendBox(box, Corner::Load(bin[k].bounds.lower), Corner::Load(bin[k].bounds.upper));
      count += bin[k].count;
      candidate[k].left_box = box;
      candidate[k].left_count = count;
    }
    box = Box::Empty();
    count = 0;
    for (uint32_t k = bins - 1; k > 0; --k) {
      ExtendBox(box, Corner::Load(bin[k].bounds.lower), Corner::Load(bin[k].bounds.upper));
      count += bin[k].count;
      candidate[k - 1].right_box = box;
      candidate[k - 1].right_count = count;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_BINNING_INL_H_
