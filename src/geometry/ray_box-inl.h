// Rays against a box, a vector of rays at a time: the slab test, made conservative.
//
// Every test of the recursion is this one, so the answer for a box never depends on how the rays or
// the triangles were grouped. Two properties carry the promise that the same ray gets the same
// bits, whatever the partition:
//   conservative  A ray that meets a triangle within the rounding of the triangle test enters the
//                 triangle's box: boxes are widened by kBoxWidening, distances by kDistanceSlack.
//   monotone      If box A lies in box B, B is entered no later and left no earlier than A, bit for
//                 bit, because each operation is monotone and rounded the same way in both. A ray
//                 that goes its own way asks nodes in other operations, with as much more slack
//                 (SlackReciprocals, and kPlaneMargin in wide_node-inl.h) as their rounding can
//                 differ.

#if defined(DACRT_GEOMETRY_RAY_BOX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_RAY_BOX_INL_H_
#undef DACRT_GEOMETRY_RAY_BOX_INL_H_
#else
#define DACRT_GEOMETRY_RAY_BOX_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using DU = hn::RebindToUnsigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
constexpr D kFloat;
constexpr DU kUint;

/// Rays in a vector.
HWY_INLINE size_t Lanes() { return hn::Lanes(kFloat); }

/// One bit a lane.
template <class Tag>
HWY_INLINE uint64_t Bits(Tag tag, hn::Mask<Tag> mask) {
#if HWY_TARGET <= HWY_AVX3
  (void)tag;
  return static_cast<uint64_t>(mask.raw) & ((uint64_t{1} << hn::MaxLanes(tag)) - 1);
#elif HWY_TARGET <= HWY_AVX2
  if constexpr (hn::MaxLanes(Tag()) == 8) {
    return static_cast<uint32_t>(_mm256_movemask_ps(hn::VecFromMask(tag, mask).raw));
  }
#endif
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  uint64_t bits;
  memcpy(&bits, bytes, sizeof(bits));
  return bits;
}
HWY_INLINE uint64_t Bits(M mask) { return Bits(kFloat, mask); }

/// The way back from Bits.
template <class Tag>
HWY_INLINE hn::Mask<Tag> MaskOf(Tag tag, uint64_t bits) {
  uint8_t bytes[8];
  memcpy(bytes, &bits, sizeof(bits));
  return hn::LoadMaskBits(tag, bytes);
}
HWY_INLINE M MaskOf(uint64_t bits) { return MaskOf(kFloat, bits); }

/// Relative widening of a box, two units in the last place: a ray that runs exactly in a face of
/// the box counts as inside, also when its direction's component is zero.
constexpr float kBoxWidening = 0x1p-22f;
/// Absolute widening, for faces at zero. In a scene that is smaller than this no box is of use: a
/// ray that comes near is tested against all of it.
constexpr float kBoxWideningAbsolute = 1e-20f;
/// Relative slack of the distances to the box's planes. The slab test itself errs by 2^-22; the
/// rest covers the rounding of the triangle test, whose hits may lie beside the triangle.
constexpr float kDistanceSlack = 0x1p-16f;
/// A component of a direction below this is treated as this, with its sign. Its reciprocal times
/// the smallest widening is beyond every distance, and no product becomes 0 * infinity.
constexpr float kSmallestDirection = 1e-36f;

/// A widened box in each lane.
template <class Vec>
struct WideBoxOf {
  Vec lower[3];
  Vec upper[3];
};
using WideBox = WideBoxOf<V>;

/// `value` in all lanes of a vector like `like`.
template <class Vec>
HWY_INLINE Vec SetLike(Vec, float value) {
  return hn::Set(hn::DFromV<Vec>(), value);
}

/// One after the other: the sum of the two would move in larger steps than a small x, and the
/// result would not be monotone.
template <class Vec>
HWY_INLINE Vec WidenDown(Vec x) {
  const Vec relative = hn::Sub(x, hn::Mul(hn::Abs(x), SetLike(x, kBoxWidening)));
  return hn::Sub(relative, SetLike(x, kBoxWideningAbsolute));
}

template <class Vec>
HWY_INLINE Vec WidenUp(Vec x) {
  const Vec relative = hn::Add(x, hn::Mul(hn::Abs(x), SetLike(x, kBoxWidening)));
  return hn::Add(relative, SetLike(x, kBoxWideningAbsolute));
}

HWY_INLINE WideBox Widen(const float* lower, const float* upper) {
  WideBox wide;
  for (int axis = 0; axis < 3; ++axis) {
    wide.lower[axis] = WidenDown(hn::Set(kFloat, lower[axis]));
    wide.upper[axis] = WidenUp(hn::Set(kFloat, upper[axis]));
  }
  return wide;
}

/// Reciprocal of a component of the direction. Finite for every finite component.
template <class Vec>
HWY_INLINE Vec SafeReciprocal(Vec direction) {
  const Vec magnitude = hn::Max(hn::Abs(direction), SetLike(direction, kSmallestDirection));
  return hn::Div(SetLike(direction, 1.0f), hn::CopySign(magnitude, direction));
}

/// Where a ray is in a box: between `entry` and `exit`, both with slack; empty if entry > exit.
template <class Vec>
struct IntervalOf {
  Vec entry;
  Vec exit;
};
using Interval = IntervalOf<V>;

/// The slab test where it is known through which planes a ray enters and leaves a box on each axis.
template <class Vec>
HWY_INLINE IntervalOf<Vec> IntersectPlanes(const Vec* near, const Vec* far, const Vec* origin,
                                           const Vec* reciprocal) {
  Vec entry = hn::Mul(hn::Sub(near[0], origin[0]), reciprocal[0]);
  Vec exit = hn::Mul(hn::Sub(far[0], origin[0]), reciprocal[0]);
  for (int axis = 1; axis < 3; ++axis) {
    entry = hn::Max(entry, hn::Mul(hn::Sub(near[axis], origin[axis]), reciprocal[axis]));
    exit = hn::Min(exit, hn::Mul(hn::Sub(far[axis], origin[axis]), reciprocal[axis]));
  }
  return {hn::Mul(entry, SetLike(entry, 1.0f - kDistanceSlack)),
          hn::Mul(exit, SetLike(exit, 1.0f + kDistanceSlack))};
}

/// Reciprocals that have the slack in them, for a ray that meets many boxes one after the other,
/// where each waits for the last: two multiplications are done once.
template <class Vec>
struct SlackReciprocals {
  /// What is rounded otherwise than by IntersectPlanes needs a little more slack: no box is to be
  /// entered later, or left earlier.
  static constexpr float kSlack = 1.25f * kDistanceSlack;

  Vec near[3], far[3];

  HWY_INLINE explicit SlackReciprocals(const Vec* reciprocal) {
    for (int axis = 0; axis < 3; ++axis) {
      near[axis] = hn::Mul(reciprocal[axis], SetLike(reciprocal[axis], 1.0f - kSlack));
      far[axis] = hn::Mul(reciprocal[axis], SetLike(reciprocal[axis], 1.0f + kSlack));
    }
  }
};

/// Where a ray is between two planes of an axis, or of several axes.
template <class Vec>
struct SlabsOf {
  Vec entry, exit;

  /// The slab of an axis.
  static HWY_INLINE SlabsOf Of(Vec lower, Vec upper, Vec origin, Vec reciprocal) {
    const Vec t0 = hn::Mul(hn::Sub(lower, origin), reciprocal);
    const Vec t1 = hn::Mul(hn::Sub(upper, origin), reciprocal);
    return {hn::Min(t0, t1), hn::Max(t0, t1)};
  }

  HWY_INLINE void Cut(const SlabsOf& other) {
    entry = hn::Max(entry, other.entry);
    exit = hn::Min(exit, other.exit);
  }

  HWY_INLINE IntervalOf<Vec> Interval() const {
    return {hn::Mul(entry, SetLike(entry, 1.0f - kDistanceSlack)),
            hn::Mul(exit, SetLike(exit, 1.0f + kDistanceSlack))};
  }
};

/// The slab test axis by axis: `slab(axis)` is the slab of one.
template <class Slab>
HWY_INLINE auto IntersectSlabs(const Slab& slab) {
  auto slabs = slab(0);
  slabs.Cut(slab(1));
  slabs.Cut(slab(2));
  return slabs.Interval();
}

template <class Vec>
HWY_INLINE IntervalOf<Vec> IntersectBox(const WideBoxOf<Vec>& box, const Vec* origin,
                                        const Vec* reciprocal) {
  return IntersectSlabs([&](int axis) HWY_ATTR {
    return SlabsOf<Vec>::Of(box.lower[axis], box.upper[axis], origin[axis], reciprocal[axis]);
  });
}

/// Rays that are in the box somewhere in [max(tnear, 0), tfar].
template <class Vec>
HWY_INLINE auto Enters(const IntervalOf<Vec>& interval, Vec tnear, Vec tfar) {
  const Vec first = hn::Max(interval.entry, hn::Max(tnear, hn::Zero(hn::DFromV<Vec>())));
  return hn::Le(first, hn::Min(interval.exit, tfar));
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_RAY_BOX_INL_H_
