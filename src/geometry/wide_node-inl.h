// Encoding and decoding the child volumes of a kept node.

#if defined(DACRT_GEOMETRY_WIDE_NODE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_GEOMETRY_WIDE_NODE_INL_H_
#undef DACRT_GEOMETRY_WIDE_NODE_INL_H_
#else
#define DACRT_GEOMETRY_WIDE_NODE_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

#include "geometry/box.h"
#include "geometry/ray_box-inl.h"
#include "geometry/wide_node.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// A vector of child volumes, a lane each; where vectors are shorter, a part of the eight.
using ChildTag = hn::CappedTag<float, WideNode::kWidth>;
using ChildVec = hn::Vec<ChildTag>;
constexpr ChildTag kChildTag;
HWY_INLINE size_t ChildLanes() { return hn::Lanes(kChildTag); }

/// The child volumes of a node, widened (see ray_box-inl.h).
struct ChildBoxes {
  HWY_ALIGN float lower[3][WideNode::kWidth];
  HWY_ALIGN float upper[3][WideNode::kWidth];
};

inline float FromUpperHalf(uint16_t half) {
  const uint32_t bits = uint32_t{half} << 16;
  float value;
  memcpy(&value, &bits, sizeof(value));
  return value;
}

/// The number with a 16-bit form that is not below `value`, which is not negative.
inline uint16_t UpperHalfNotBelow(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof(bits));
  return static_cast<uint16_t>((bits + 0xFFFFu) >> 16);
}

HWY_INLINE ChildVec DecodeFaces(const uint8_t* steps, float origin, float scale) {
  const hn::RebindToSigned<ChildTag> di;
  const hn::Rebind<uint8_t, ChildTag> d8;
  const auto count = hn::ConvertTo(kChildTag, hn::PromoteTo(di, hn::LoadU(d8, steps)));
  return hn::Add(hn::Mul(count, hn::Set(kChildTag, scale)), hn::Set(kChildTag, origin));
}

HWY_INLINE ChildVec WidenChildrenDown(ChildVec x) {
  const auto relative = hn::Sub(x, hn::Mul(hn::Abs(x), hn::Set(kChildTag, kBoxWidening)));
  return hn::Sub(relative, hn::Set(kChildTag, kBoxWideningAbsolute));
}

/// Part `i` of the lower or upper faces on an axis, widened.
HWY_INLINE ChildVec WideLower(const WideNode& node, int axis, size_t i) {
  return WidenChildrenDown(
      DecodeFaces(node.lower[axis] + i, node.origin[axis], FromUpperHalf(node.scale[axis])));
}
HWY_INLINE ChildVec WideUpper(const WideNode& node, int axis, size_t i) {
  return hn::Neg(WidenChildrenDown(hn::Neg(
      DecodeFaces(node.upper[axis] + i, node.origin[axis], FromUpperHalf(node.scale[axis])))));
}

HWY_INLINE void DecodeChildren(const WideNode& node, ChildBoxes& boxes) {
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < WideNode::kWidth; i += ChildLanes()) {
      hn::Store(WideLower(node, axis, i), kChildTag, boxes.lower[axis] + i);
      hn::Store(WideUpper(node, axis, i), kChildTag, boxes.upper[axis] + i);
    }
  }
}

/// Child i in all lanes.
HWY_INLINE WideBox WideChild(const ChildBoxes& boxes, size_t i) {
  WideBox box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = hn::Set(kFloat, boxes.lower[axis][i]);
    box.upper[axis] = hn::Set(kFloat, boxes.upper[axis][i]);
  }
  return box;
}

/// The volume that holds children [begin, end).
HWY_INLINE WideBox UnionOfChildren(const ChildBoxes& boxes, size_t begin, size_t end) {
  WideBox all = WideChild(boxes, begin);
  for (size_t i = begin + 1; i < end; ++i) {
    const WideBox box = WideChild(boxes, i);
    for (int axis = 0; axis < 3; ++axis) {
      all.lower[axis] = hn::Min(all.lower[axis], box.lower[axis]);
      all.upper[axis] = hn::Max(all.upper[axis], box.upper[axis]);
    }
  }
  return all;
}

/// Sets the boxes of `node` to volumes that hold `boxes`. Unused children get an empty volume.
inline void EncodeChildren(const Box& bounds, const Box* const* boxes, size_t count,
                           WideNode& node) {
  node.count = static_cast<uint16_t>(count);
  const hn::RebindToSigned<ChildTag> di;
  const hn::Rebind<uint8_t, ChildTag> d8;
  for (int axis = 0; axis < 3; ++axis) {
    const float origin = bounds.lower[axis];
    node.origin[axis] = origin;
    uint16_t scale = UpperHalfNotBelow((bounds.upper[axis] - origin) / 255.0f);
    while (origin + 255.0f * FromUpperHalf(scale) < bounds.upper[axis]) ++scale;
    node.scale[axis] = scale;
    const float step = FromUpperHalf(scale);
    HWY_ALIGN float lower[WideNode::kWidth], upper[WideNode::kWidth];
    for (size_t i = 0; i < WideNode::kWidth; ++i) {
      lower[i] = i < count ? boxes[i]->lower[axis] : bounds.upper[axis];
      upper[i] = i < count ? boxes[i]->upper[axis] : origin;
    }
    const auto one = hn::Set(di, 1);
    const auto least = hn::Zero(di), most = hn::Set(di, 255);
    const auto v_origin = hn::Set(kChildTag, origin), v_step = hn::Set(kChildTag, step);
    const auto v_inverse = hn::Set(kChildTag, step > 0 ? 1.0f / step : 0.0f);
    const auto decode = [&](hn::Vec<decltype(di)> steps) HWY_ATTR {
      return hn::Add(hn::Mul(hn::ConvertTo(kChildTag, steps), v_step), v_origin);
    };
    for (size_t i = 0; i < WideNode::kWidth; i += ChildLanes()) {
      const auto low = hn::Load(kChildTag, lower + i), high = hn::Load(kChildTag, upper + i);
      // Rounding may leave the guess a step inside the box on either side.
      const auto guess = [&](ChildVec face) HWY_ATTR {
        return hn::Min(
            hn::Max(hn::ConvertTo(di, hn::Mul(hn::Sub(face, v_origin), v_inverse)), least), most);
      };
      auto down = guess(low), up = guess(high);
      const auto above = hn::RebindMask(di, hn::Gt(decode(down), low));
      down = hn::Max(hn::IfThenElse(above, hn::Sub(down, one), down), least);
      for (int round = 0; round < 2; ++round) {
        const auto below = hn::RebindMask(di, hn::Lt(decode(up), high));
        up = hn::Min(hn::IfThenElse(below, hn::Add(up, one), up), most);
      }
      hn::StoreU(hn::DemoteTo(d8, down), d8, node.lower[axis] + i);
      hn::StoreU(hn::DemoteTo(d8, up), d8, node.upper[axis] + i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_GEOMETRY_WIDE_NODE_INL_H_
