// Binning: the triangles of a subproblem counted by their centres, and the candidate partitions
// between the bins. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.

#if defined(DACRT_PARTITION_BINNING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PARTITION_BINNING_INL_H_
#undef DACRT_PARTITION_BINNING_INL_H_
#else
#define DACRT_PARTITION_BINNING_INL_H_
#endif

#include "geometry/corner-inl.h"
#include "geometry/triangle_refs.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
/// Maps centres to bins, the same for counting and for partitioning.
class BinMap {
 public:
  BinMap(const Box& centers, uint32_t bins) : bins_(bins) {
    for (int axis = 0; axis < 3; ++axis) {
      const float extent = centers.upper[axis] - centers.lower[axis];
      lower_[axis] = centers.lower[axis];
      // Slightly below the count, so that the last centre falls into the last bin.
      scale_[axis] = extent > 0 ? static_cast<float>(bins) * 0.99999f / extent : 0;
      // An extent so small that its reciprocal overflows can not be divided.
      if (!(scale_[axis] < 1e30f)) scale_[axis] = 0;
    }
  }

  /// Whether centres differ on an axis at all.
  bool IsUseful(int axis) const { return scale_[axis] > 0; }

  /// Where bin k ends.
  float Boundary(int axis, uint32_t k) const {
    return lower_[axis] + static_cast<float>(k + 1) / scale_[axis];
  }

  /// Bin numbers on three axes; bin[3] is scrap.
  HWY_INLINE void Map(const Corner& center, int32_t* HWY_RESTRICT bin) const {
    const hn::RebindToSigned<CornerTag> di;
    const Corner lower = Corner::Load(lower_), scale = Corner::Load(scale_);
    const auto last = hn::Set(di, static_cast<int32_t>(bins_) - 1);
    for (size_t i = 0; i < kCornerParts; ++i) {
      const auto place = hn::Mul(hn::Sub(center.part[i], lower.part[i]), scale.part[i]);
      const auto number = hn::Min(hn::Max(hn::ConvertTo(di, place), hn::Zero(di)), last);
      hn::Store(number, di, bin + i * hn::MaxLanes(di));
    }
  }

 private:
  alignas(16) float lower_[4] = {};
  alignas(16) float scale_[4] = {};
  uint32_t bins_;
};

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

#endif  // DACRT_PARTITION_BINNING_INL_H_
