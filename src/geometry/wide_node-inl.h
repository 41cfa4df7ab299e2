// Encoding and decoding the child volumes of a kept node.

#if defined(DACRT_GEOMETRY_WIDE_NODE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_WIDE_NODE_INL_H_
#undef DACRT_GEOMETRY_WIDE_NODE_INL_H_
#else
#define DACRT_GEOMETRY_WIDE_NODE_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "geometry/box.h"
#include "geometry/four_by_four-inl.h"
#include "geometry/ray_box-inl.h"
#include "geometry/wide_node.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A vector of eight values, a lane each; where vectors are shorter, a part of the eight.
using EightTag = hn::CappedTag<float, 8>;
using EightPart = hn::Vec<EightTag>;
constexpr EightTag kEightTag;
constexpr size_t kPartLanes = hn::MaxLanes(EightTag());
constexpr size_t kParts = 8 / kPartLanes;

/// The number of eight bits that is not below `value`, which is not negative.
inline float EightBitsNotBelow(float value) {
  return std::bit_cast<float>((std::bit_cast<uint32_t>(value) + 0xFFFFu) & 0xFFFF0000u);
}

/// The one after such a number.
inline float NextOfEightBits(float value) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(value) + 0x10000u);
}

/// The largest number below a finite one that is not the least.
inline float NextBelow(float value) {
  const auto bits = std::bit_cast<int32_t>(value);
  if (value == 0) return -std::numeric_limits<float>::denorm_min();
  return std::bit_cast<float>(bits > 0 ? bits - 1 : bits + 1);
}

/// By how much the planes of a node stand off the volumes of its children, relative to the node.
constexpr float kPlaneMargin = 0x1p-21f;

/// Faces of some children on an axis, of a node that is not exact. They are widened already (see
/// ray_box-inl.h).
HWY_INLINE EightPart DecodeFaces(const uint8_t* steps, EightPart origin, EightPart scale) {
  const hn::RebindToSigned<EightTag> di;
  const hn::Rebind<uint8_t, EightTag> d8;
  const auto count = hn::ConvertTo(kEightTag, hn::PromoteTo(di, hn::LoadU(d8, steps)));
  return hn::MulAdd(count, scale, origin);
}

/// Where the planes stand in a node through which rays of an octant enter and leave its children.
struct PlaneOffsets {
  uint32_t near[3];
  uint32_t far[3];

  /// `octant` has a bit for each axis on which directions are negative.
  constexpr explicit PlaneOffsets(uint32_t octant) : near(), far() {
    static_assert(offsetof(WideNode, upper) == offsetof(WideNode, lower) + 3 * WideNode::kWidth);
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const uint32_t negative = (octant >> axis) & 1;
      near[axis] = WideNode::kWidth * (axis + 3 * negative);
      far[axis] = WideNode::kWidth * (axis + 3 * (1 - negative));
    }
  }
};

/// The same by octant, for those who look them up once a ray.
inline constexpr PlaneOffsets kPlaneOffsets[8] = {PlaneOffsets(0), PlaneOffsets(1), PlaneOffsets(2),
                                                  PlaneOffsets(3), PlaneOffsets(4), PlaneOffsets(5),
                                                  PlaneOffsets(6), PlaneOffsets(7)};

/// These planes of an exact node, a lane a child, and a part of the children at a time.
/// `move(plane, axis)` says from where they are counted.
template <class Move>
struct ExactPlanes {
  HWY_INLINE ExactPlanes(const WideNode& node, const PlaneOffsets& offsets, const Move& move)
      : faces(node.ExactFaces()), offsets(offsets), move(move) {}

  HWY_INLINE EightPart Near(size_t part, int axis) const { return At(offsets.near, part, axis); }
  HWY_INLINE EightPart Far(size_t part, int axis) const { return At(offsets.far, part, axis); }

 private:
  HWY_INLINE EightPart At(const uint32_t* offset, size_t part, int axis) const {
    return move(hn::Load(kEightTag, faces + offset[axis] + part * kPartLanes), axis);
  }

  const float* const faces;
  const PlaneOffsets& offsets;
  const Move& move;
};

/// The same of another node. The origin is moved while steps are converted.
template <class Move>
struct SteppedPlanes {
  HWY_INLINE SteppedPlanes(const WideNode& node, const PlaneOffsets& offsets, const Move& move)
      : steps(&node.lower[0][0]), offsets(offsets) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = move(hn::Set(kEightTag, node.origin[axis]), axis);
      scale[axis] = hn::Set(kEightTag, node.scale[axis]);
    }
  }

  HWY_INLINE EightPart Near(size_t part, int axis) const { return At(offsets.near, part, axis); }
  HWY_INLINE EightPart Far(size_t part, int axis) const { return At(offsets.far, part, axis); }

 private:
  HWY_INLINE EightPart At(const uint32_t* offset, size_t part, int axis) const {
    return DecodeFaces(steps + offset[axis] + part * kPartLanes, origin[axis], scale[axis]);
  }

  const uint8_t* const steps;
  const PlaneOffsets& offsets;
  EightPart origin[3], scale[3];
};

/// The same of any node, in registers.
struct ChildPlanes {
  EightPart near[kParts][3];
  EightPart far[kParts][3];

  HWY_INLINE ChildPlanes(const WideNode& node, const PlaneOffsets& offsets)
      : ChildPlanes(node, offsets, [](EightPart plane, int) HWY_ATTR { return plane; }) {}

  template <class Move>
  HWY_INLINE ChildPlanes(const WideNode& node, const PlaneOffsets& offsets, const Move& move) {
    if (HWY_LIKELY(node.is_exact)) {
      Load(ExactPlanes(node, offsets, move));
    } else {
      Load(SteppedPlanes(node, offsets, move));
    }
  }

  HWY_INLINE EightPart Near(size_t part, int axis) const { return near[part][axis]; }
  HWY_INLINE EightPart Far(size_t part, int axis) const { return far[part][axis]; }

 private:
  template <class Planes>
  HWY_INLINE void Load(const Planes& planes) {
    for (int axis = 0; axis < 3; ++axis) {
      for (size_t part = 0; part < kParts; ++part) {
        near[part][axis] = planes.Near(part, axis);
        far[part][axis] = planes.Far(part, axis);
      }
    }
  }
};

/// The boxes of a node's children, axis by axis.
struct ChildFaces {
  HWY_ALIGN float lower[3][WideNode::kWidth];
  HWY_ALIGN float upper[3][WideNode::kWidth];

  /// Sets the volumes of `node`, which is exact or not, to ones that hold the first `count`,
  /// widened; the others are as the first. Unused children get volumes that are inside out.
  void Encode(size_t count, WideNode& node) {
    DACRT_ASSERT(count >= 1 && count <= WideNode::kWidth);
    node.count = static_cast<uint8_t>(count);
    for (int axis = 0; axis < 3; ++axis) {
      Extremes all = WidenAxis(axis);
      if (node.is_exact) {
        StoreAxis(axis, all, node);
      } else {
        EncodeAxis(axis, all, node);
      }
    }
  }
  /// To the volumes of an exact one.
  void Encode(const ExactNode& exact, WideNode& node) {
    node.count = exact.count;
    memcpy(lower, exact.ExactFaces(), sizeof(lower));
    memcpy(upper, exact.ExactFaces() + 3 * WideNode::kWidth, sizeof(upper));
    for (int axis = 0; axis < 3; ++axis) {
      // Those of unused children are the ends of all.
      Extremes all = {lower[axis][0], upper[axis][0]};
      for (size_t i = 0; i < node.count; ++i) {
        all.lower = HWY_MIN(all.lower, lower[axis][i]);
        all.upper = HWY_MAX(all.upper, upper[axis][i]);
      }
      for (size_t i = node.count; i < WideNode::kWidth; ++i) {
        lower[axis][i] = all.lower;
        upper[axis][i] = all.upper;
      }
      EncodeAxis(axis, all, node);
    }
  }

 private:
  /// Of all the boxes on an axis.
  struct Extremes {
    float lower, upper;
  };

  Extremes WidenAxis(int axis);
  void StoreAxis(int axis, const Extremes& all, WideNode& node) const;
  void EncodeAxis(int axis, const Extremes& all, WideNode& node) const;
};

inline ChildFaces::Extremes ChildFaces::WidenAxis(int axis) {
  Extremes all = {lower[axis][0], upper[axis][0]};
  for (size_t i = 0; i < WideNode::kWidth; i += kPartLanes) {
    const auto low = WidenDown(hn::Load(kEightTag, lower[axis] + i));
    const auto high = WidenUp(hn::Load(kEightTag, upper[axis] + i));
    hn::Store(low, kEightTag, lower[axis] + i);
    hn::Store(high, kEightTag, upper[axis] + i);
    all.lower = HWY_MIN(all.lower, hn::GetLane(hn::MinOfLanes(kEightTag, low)));
    all.upper = HWY_MAX(all.upper, hn::GetLane(hn::MaxOfLanes(kEightTag, high)));
  }
  return all;
}

inline void ChildFaces::StoreAxis(int axis, const Extremes& all, WideNode& node) const {
  float* const low_faces = node.ExactFaces() + axis * WideNode::kWidth;
  float* const high_faces = low_faces + 3 * WideNode::kWidth;
  for (size_t i = 0; i < WideNode::kWidth; i += kPartLanes) {
    hn::Store(hn::Load(kEightTag, lower[axis] + i), kEightTag, low_faces + i);
    hn::Store(hn::Load(kEightTag, upper[axis] + i), kEightTag, high_faces + i);
  }
  for (size_t i = node.count; i < WideNode::kWidth; ++i) {
    low_faces[i] = all.upper;
    high_faces[i] = all.lower;
  }
}

inline void ChildFaces::EncodeAxis(int axis, const Extremes& all, WideNode& node) const {
  const hn::RebindToSigned<EightTag> di;
  const hn::Rebind<uint8_t, EightTag> d8;
  const float* const low_faces = lower[axis];
  const float* const high_faces = upper[axis];
  float origin = all.lower;
  const float end = all.upper;
  // Planes stand off by more than what origin - org is rounded by.
  const float margin = (end - origin) * kPlaneMargin;
  origin = std::min(origin - margin, NextBelow(origin));
  const float extent = end - origin + margin;
  float step = EightBitsNotBelow(extent / 255.0f);
  // Of two numbers of eight bits the product is exact.
  while (255.0f * step < extent) step = NextOfEightBits(step);
  node.origin[axis] = origin;
  node.scale[axis] = step;
  const auto v_step = hn::Set(kEightTag, step), v_origin = hn::Set(kEightTag, origin),
             v_margin = hn::Set(kEightTag, margin),
             v_inverse = hn::Set(kEightTag, step > 0 ? 1.0f / step : 0.0f);
  const auto least = hn::Zero(di), most = hn::Set(di, 255), one = hn::Set(di, 1);
  const auto offset = [&](hn::Vec<decltype(di)> steps)
                          HWY_ATTR { return hn::Mul(hn::ConvertTo(kEightTag, steps), v_step); };
  for (size_t i = 0; i < WideNode::kWidth; i += kPartLanes) {
    const auto low = hn::Sub(hn::Sub(hn::Load(kEightTag, low_faces + i), v_origin), v_margin);
    const auto high = hn::Add(hn::Sub(hn::Load(kEightTag, high_faces + i), v_origin), v_margin);
    // Rounding may leave the guess a step inside the box on either side.
    const auto guess = [&](EightPart face) HWY_ATTR {
      return hn::Min(hn::Max(hn::ConvertTo(di, hn::Mul(face, v_inverse)), least), most);
    };
    auto down = guess(low), up = guess(high);
    for (int round = 0; round < 2; ++round) {
      const auto above = hn::RebindMask(di, hn::Gt(offset(down), low));
      down = hn::Max(hn::IfThenElse(above, hn::Sub(down, one), down), least);
      const auto below = hn::RebindMask(di, hn::Lt(offset(up), high));
      up = hn::Min(hn::IfThenElse(below, hn::Add(up, one), up), most);
    }
    hn::StoreU(hn::DemoteTo(d8, down), d8, node.lower[axis] + i);
    hn::StoreU(hn::DemoteTo(d8, up), d8, node.upper[axis] + i);
  }
  for (size_t i = node.count; i < WideNode::kWidth; ++i) {
    node.lower[axis][i] = 255;
    node.upper[axis][i] = 0;
  }
}

/// The same box by box. What is written as vectors is read as vectors: a value that was written
/// alone has to reach memory before a vector with it can be read.
class ChildBoxes {
 public:
  /// Behind the three values of each corner there is a fourth, which counts for nothing.
  template <class Corners>
  HWY_INLINE void Set(size_t i, const Corners& box) {
    Corner::LoadUnaligned(box.lower).Store(lower_[i]);
    Corner::LoadUnaligned(box.upper).Store(upper_[i]);
  }

  /// Makes points of those of the first `count` boxes that are empty.
  void FillEmpty(size_t count) {
    const auto is_empty = [&](size_t i) { return !(lower_[i][0] <= upper_[i][0]); };
    size_t full = 0;
    while (full < count && is_empty(full)) ++full;
    for (size_t i = 0; i < count; ++i) {
      if (HWY_LIKELY(!is_empty(i))) continue;
      const Corner point = full < count ? Corner::Load(lower_[full]) : Corner::Set(0);
      point.Store(lower_[i]);
      point.Store(upper_[i]);
    }
  }

  /// See ChildFaces.
  void Encode(size_t count, WideNode& node) {
    for (size_t i = count; i < WideNode::kWidth; ++i) {
      Corner::Load(lower_[0]).Store(lower_[i]);
      Corner::Load(upper_[0]).Store(upper_[i]);
    }
    ChildFaces faces;
    Transpose(lower_, faces.lower);
    Transpose(upper_, faces.upper);
    faces.Encode(count, node);
  }

 private:
  using Rows = float[WideNode::kWidth][4];

  static HWY_INLINE void Transpose(const Rows& rows, float (&faces)[3][WideNode::kWidth]) {
#if HWY_TARGET == HWY_SCALAR
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      for (int axis = 0; axis < 3; ++axis) faces[axis][i] = rows[i][axis];
    }
#else
    for (size_t first = 0; first < WideNode::kWidth; first += kPartLanes) {
      auto corners = FourByFour<EightTag>::Load([&](size_t i) { return rows[first + i]; });
      corners.Transpose();
      for (int axis = 0; axis < 3; ++axis) {
        hn::Store(corners.v[axis], kEightTag, faces[axis] + first);
      }
    }
#endif
  }

  HWY_ALIGN Rows lower_;
  HWY_ALIGN Rows upper_;
};

/// The same for boxes that stand anywhere.
inline void EncodeChildren(const Box* const* boxes, size_t count, WideNode& node) {
  ChildBoxes all;
  for (size_t i = 0; i < count; ++i) all.Set(i, *boxes[i]);
  all.Encode(count, node);
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_WIDE_NODE_INL_H_
