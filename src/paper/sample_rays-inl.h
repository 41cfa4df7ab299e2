// Ray sampling: a few of the active rays, traced against volumes in the place of all of them.
// Nabata et al. 2013, "Ray Sampling".

#if defined(DACRT_PAPER_SAMPLE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_SAMPLE_RAYS_INL_H_
#undef DACRT_PAPER_SAMPLE_RAYS_INL_H_
#else
#define DACRT_PAPER_SAMPLE_RAYS_INL_H_
#endif

#include <algorithm>

#include "geometry/ray_box-inl.h"
#include "paper/ray_batch.h"
#include "runtime/scratch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Copies `count` of the rays, or all if there are fewer: one from each of `count` equal stretches
/// of the block, at a place in the stretch that varies, so that a period of the caller's order (a
/// row of pixels, a cycle of samples) does not become a bias. The same block gives the same sample.
inline void TakeSampleRays(const RayBatch& batch, const RayBlock& rays, size_t count,
                           SampleRays& samples) {
  samples.count = std::min({count, rays.count, SampleRays::kCapacity});
  uint32_t random = 0x9E3779B9u;
  for (size_t i = 0; i < samples.count; ++i) {
    const uint64_t begin = i * rays.count / samples.count;
    const uint64_t end = (i + 1) * rays.count / samples.count;
    random = random * 1664525u + 1013904223u;  // Numerical Recipes' generator
    const size_t slot = rays.begin + begin + (((end - begin) * (random >> 8)) >> 24);
    for (int axis = 0; axis < 3; ++axis) {
      samples.org[axis][i] = batch.org[axis][slot];
      samples.reciprocal[axis][i] = batch.dir[axis][slot];
    }
    samples.tnear[i] = batch.tnear[slot];
    samples.tfar[i] = batch.tfar[slot];
  }
  const size_t padded = hwy::RoundUpTo(samples.count, Lanes());
  for (size_t i = samples.count; i < padded; ++i) {
    for (int axis = 0; axis < 3; ++axis) samples.org[axis][i] = samples.reciprocal[axis][i] = 0;
    samples.tnear[i] = kInactiveTNear;
    samples.tfar[i] = kInactiveTFar;
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < padded; i += Lanes()) {
      float* reciprocal = samples.reciprocal[axis] + i;
      hn::Store(SafeReciprocal(hn::Load(kFloat, reciprocal)), kFloat, reciprocal);
    }
  }
}

/// How many of `active_rays` to take where `least` are asked for; see Settings::sample_rays.
inline size_t SampleCount(size_t active_rays, size_t least) {
  constexpr size_t kRaysPerSample = 512;
  return std::clamp(active_rays / kRaysPerSample, least, SampleRays::kCapacity);
}

/// How the sample rays meet two child volumes. A ray is closer to the one that it enters first; one
/// that misses a volume is closer to neither, because it does not care which comes first. (Counting
/// it for the volume that it enters made 5 to 25 per cent more triangle tests.)
struct SampleCounts {
  size_t left_hits = 0;
  size_t right_hits = 0;
  size_t left_closer = 0;
  size_t right_closer = 0;
};

inline SampleCounts CountSamples(const SampleRays& samples, const Box& left, const Box& right) {
  const WideBox left_box = Widen(left.lower, left.upper);
  const WideBox right_box = Widen(right.lower, right.upper);
  SampleCounts counts;
  for (size_t i = 0; i < samples.count; i += Lanes()) {
    V org[3], reciprocal[3];
    for (int axis = 0; axis < 3; ++axis) {
      org[axis] = hn::Load(kFloat, samples.org[axis] + i);
      reciprocal[axis] = hn::Load(kFloat, samples.reciprocal[axis] + i);
    }
    const V tnear = hn::Load(kFloat, samples.tnear + i);
    const V tfar = hn::Load(kFloat, samples.tfar + i);
    const Interval left_interval = IntersectBox(left_box, org, reciprocal);
    const Interval right_interval = IntersectBox(right_box, org, reciprocal);
    const M left_hit = Enters(left_interval, tnear, tfar);
    const M right_hit = Enters(right_interval, tnear, tfar);
    const V first = hn::Max(tnear, hn::Zero(kFloat));
    const V left_entry = hn::Max(left_interval.entry, first);
    const V right_entry = hn::Max(right_interval.entry, first);
    const M both = hn::And(left_hit, right_hit);
    const M left_first = hn::And(both, hn::Lt(left_entry, right_entry));
    const M right_first = hn::And(both, hn::Lt(right_entry, left_entry));
    counts.left_hits += hn::CountTrue(kFloat, left_hit);
    counts.right_hits += hn::CountTrue(kFloat, right_hit);
    counts.left_closer += hn::CountTrue(kFloat, left_first);
    counts.right_closer += hn::CountTrue(kFloat, right_first);
  }
  return counts;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_SAMPLE_RAYS_INL_H_
