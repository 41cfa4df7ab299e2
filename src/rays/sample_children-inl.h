// The children of a kept node, traced by a vector of sample rays or packets.
// Nabata et al. 2013, "Ray Sampling".

#if defined(DACRT_RAYS_SAMPLE_CHILDREN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_RAYS_SAMPLE_CHILDREN_INL_H_
#undef DACRT_RAYS_SAMPLE_CHILDREN_INL_H_
#else
#define DACRT_RAYS_SAMPLE_CHILDREN_INL_H_
#endif

#include <algorithm>
#include <limits>

#include "geometry/wide_node-inl.h"
#include "rays/box_test-inl.h"
#include "rays/sample_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays from which a sample has to be taken from all over. Fewer of them, which came through the
/// same volumes, are much alike, and a vector of neighbours is quicker to load.
constexpr size_t kManyRays = 1024;

/// How sample rays meet the children of a node.
struct ChildSamples {
  uint64_t hits[WideNode::kWidth];  ///< a bit a sample ray
  HWY_ALIGN float entry[WideNode::kWidth][kMaxLanes];
  size_t count;

  /// Children [begin, middle) against [middle, end).
  SampleCounts Count(size_t begin, size_t middle, size_t end) const {
    uint64_t left_hits = 0, right_hits = 0;
    V left_entry = hn::Set(kFloat, std::numeric_limits<float>::max());
    V right_entry = left_entry;
    for (size_t i = begin; i < middle; ++i) {
      left_hits |= hits[i];
      left_entry = hn::Min(left_entry, hn::Load(kFloat, entry[i]));
    }
    for (size_t i = middle; i < end; ++i) {
      right_hits |= hits[i];
      right_entry = hn::Min(right_entry, hn::Load(kFloat, entry[i]));
    }
    const uint64_t both = left_hits & right_hits;
    return {hwy::PopCount(left_hits), hwy::PopCount(right_hits),
            hwy::PopCount(Bits(hn::Lt(left_entry, right_entry)) & both),
            hwy::PopCount(Bits(hn::Lt(right_entry, left_entry)) & both)};
  }
};

/// Traces a vector of the block's rays or packets against the first `children` boxes.
template <class Batch>
inline void SampleChildren(const Batch& batch, const RayBlock& rays, const ChildBoxes& boxes,
                           size_t children, ChildSamples& samples) {
  constexpr size_t kTNear = Batch::kFields - 3, kTFar = Batch::kFields - 2;
  const auto fields = Fields(batch);
  auto values = LoadFields(fields, rays.begin);
  samples.count = std::min(Lanes(), rays.count);
  if (rays.count >= kManyRays) {
    HWY_ALIGN float copies[Batch::kFields][kMaxLanes];
    for (size_t i = 0; i < samples.count; ++i) {
      // One further in each stretch, against periods in the caller's order.
      const size_t slot = rays.begin + i * rays.count / samples.count + i;
      for (size_t field = 0; field < Batch::kFields; ++field) {
        copies[field][i] = fields[field][slot];
      }
    }
    for (size_t field = 0; field < Batch::kFields; ++field) {
      values[field] = hn::Load(kFloat, copies[field]);
    }
  } else if (rays.count >= 2 * Lanes()) {
    values = LoadFields(fields, rays.begin + rays.count / 2 / Lanes() * Lanes());
    samples.count = std::min(Lanes(), rays.count - rays.count / 2 / Lanes() * Lanes());
  }
  const V first = hn::Max(values[kTNear], hn::Zero(kFloat));
  const V never = hn::Set(kFloat, std::numeric_limits<float>::max());
  for (size_t i = 0; i < children; ++i) {
    const Interval interval = IntersectFields(WideChild(boxes, i), values);
    const M hit = Enters(interval, values[kTNear], values[kTFar]);
    samples.hits[i] = Bits(hit);
    hn::Store(hn::IfThenElse(hit, hn::Max(interval.entry, first), never), kFloat, samples.entry[i]);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_RAYS_SAMPLE_CHILDREN_INL_H_
