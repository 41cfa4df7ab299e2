// Conic packets: consecutive rays from one point, tested against a box as one cone.
// Mora, "Naive ray-tracing: a divide-and-conquer approach", ACM TOG 30(5), 2011.

#if defined(DACRT_PAPER_CONIC_PACKETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_PAPER_CONIC_PACKETS_INL_H_
#undef DACRT_PAPER_CONIC_PACKETS_INL_H_
#else
#define DACRT_PAPER_CONIC_PACKETS_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "geometry/ray_box-inl.h"
#include "paper/ray_batch.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Slack of the cone, relative to distances along its axis: more than the slab test's, so that the
/// cone never misses a box that one of its rays enters.
constexpr float kConeSlack = 1e-4f;

/// Whether the rays, of which there is at least one, start from one point.
inline bool HaveCommonOrigin(const RayBatch& batch, const RayBlock& rays) {
  for (size_t slot = rays.begin; slot < rays.begin + rays.count; ++slot) {
    for (int axis = 0; axis < 3; ++axis) {
      if (batch.org[axis][slot] != batch.org[axis][rays.begin]) return false;
    }
  }
  return true;
}

/// Sets how far along its axis the cone of `packet` has to be looked at: to the farthest tfar of
/// its rays that are still looking for a hit; negative if none is.
inline void UpdateReach(const RayBatch& batch, const RayBlock& packet, ConicPackets& cones) {
  float farthest = -1;
  for (size_t slot = packet.begin; slot < packet.begin + packet.count; ++slot) {
    farthest = std::max(farthest, batch.tfar[slot]);
  }
  const size_t i = packet.begin / ConicPackets::kRays;
  cones.reach[i] = farthest < 0 ? -1 : farthest * cones.longest[i];
}

/// Makes the packets of `rays`, a block that begins at slot 0, and lists them.
inline std::span<const RayBlock> MakeConicPackets(RayBatch& batch, const RayBlock& rays) {
  ConicPackets& cones = batch.cones;
  size_t packets = 0;
  for (size_t begin = 0; begin < rays.count; begin += ConicPackets::kRays, ++packets) {
    const RayBlock packet{begin, std::min(ConicPackets::kRays, rays.count - begin)};
    double axis[3] = {};
    double longest = 0;
    const auto direction = [&](size_t slot, double* unit) {
      double length = 0;
      for (int i = 0; i < 3; ++i) length += double{batch.dir[i][slot]} * batch.dir[i][slot];
      length = std::sqrt(length);
      for (int i = 0; i < 3; ++i) unit[i] = length > 0 ? batch.dir[i][slot] / length : 0;
      return length;
    };
    const auto normalize = [](double* v) {
      const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
      for (int i = 0; i < 3; ++i) v[i] = length > 0 ? v[i] / length : 0;
    };
    for (size_t slot = begin; slot < begin + packet.count; ++slot) {
      double unit[3];
      longest = std::max(longest, direction(slot, unit));
      for (int i = 0; i < 3; ++i) axis[i] += unit[i];
    }
    normalize(axis);
    double tangent = 0;
    for (size_t slot = begin; slot < begin + packet.count; ++slot) {
      double unit[3], across[3];
      direction(slot, unit);
      const double along = unit[0] * axis[0] + unit[1] * axis[1] + unit[2] * axis[2];
      for (int i = 0; i < 3; ++i) across[i] = unit[i] - along * axis[i];
      const double height =
          std::sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
      // A cone of a right angle or more, or a ray without direction: no tangent, never left out.
      tangent =
          along > 0 ? std::max(tangent, height / along) : std::numeric_limits<double>::infinity();
    }
    for (int i = 0; i < 3; ++i) cones.axis[i][packets] = static_cast<float>(axis[i]);
    cones.tangent[packets] = static_cast<float>(std::min(tangent * (1 + kConeSlack), 1e18));
    cones.longest[packets] = static_cast<float>(longest * (1 + kConeSlack));
    UpdateReach(batch, packet, cones);
    batch.packets[packets] = packet;
  }
  for (int i = 0; i < 3; ++i) cones.apex[i] = batch.org[i][rays.begin];
  return batch.packets.first(packets);
}

/// Writes those of `packets` whose cone meets `bounds` to `out`. Returns their number.
///
/// A cone is left out only if a plane shows that it does not meet the box: one across the direction
/// from the axis to the box's centre, or one across the axis.
inline size_t FilterPackets(const ConicPackets& cones, std::span<const RayBlock> packets,
                            const Box& bounds, RayBlock* out) {
  float center[3], half[3];
  for (int i = 0; i < 3; ++i) {
    center[i] = 0.5f * (bounds.lower[i] + bounds.upper[i]) - cones.apex[i];
    half[i] = 0.5f * (bounds.upper[i] - bounds.lower[i]);
  }
  const float scale =
      std::abs(center[0]) + std::abs(center[1]) + std::abs(center[2]) + half[0] + half[1] + half[2];
  const V slack = hn::Set(kFloat, scale * kConeSlack);
  const V zero = hn::Zero(kFloat);
  size_t count = 0;
  for (size_t first = 0; first < packets.size(); first += Lanes()) {
    const size_t lanes = std::min(Lanes(), packets.size() - first);
    HWY_ALIGN float columns[6][kMaxLanes] = {};
    for (size_t lane = 0; lane < lanes; ++lane) {
      const size_t i = packets[first + lane].begin / ConicPackets::kRays;
      for (int j = 0; j < 3; ++j) columns[j][lane] = cones.axis[j][i];
      columns[3][lane] = cones.tangent[i];
      columns[4][lane] = cones.reach[i];
    }
    const V axis[3] = {hn::Load(kFloat, columns[0]), hn::Load(kFloat, columns[1]),
                       hn::Load(kFloat, columns[2])};
    const V tangent = hn::Load(kFloat, columns[3]);
    const V reach = hn::Load(kFloat, columns[4]);
    V along = zero, extent_along = zero;
    for (int i = 0; i < 3; ++i) {
      along = hn::MulAdd(axis[i], hn::Set(kFloat, center[i]), along);
      extent_along = hn::MulAdd(hn::Abs(axis[i]), hn::Set(kFloat, half[i]), extent_along);
    }
    V across[3], square = zero;
    for (int i = 0; i < 3; ++i) {
      across[i] = hn::NegMulAdd(along, axis[i], hn::Set(kFloat, center[i]));
      square = hn::MulAdd(across[i], across[i], square);
    }
    const V distance = hn::Sqrt(square);
    // Times the distance, so that a box centred on the axis needs no direction.
    V extent_across = zero;
    for (int i = 0; i < 3; ++i) {
      extent_across = hn::MulAdd(hn::Abs(across[i]), hn::Set(kFloat, half[i]), extent_across);
    }
    const V farthest = hn::Add(hn::Max(hn::Add(along, extent_along), zero), slack);
    const V radius = hn::Add(hn::Mul(farthest, tangent), slack);
    const M beside = hn::Gt(hn::Sub(square, extent_across), hn::Mul(radius, distance));
    const M behind = hn::Lt(hn::Add(along, extent_along), hn::Neg(slack));
    const M beyond = hn::Gt(hn::Sub(hn::Sub(along, extent_along), slack), reach);
    // A cone wider than a right angle has no axis to speak of.
    const M wide = hn::Ge(tangent, hn::Set(kFloat, 1e17f));
    const M misses =
        hn::Or(hn::AndNot(wide, hn::Or(beside, hn::Or(behind, beyond))), hn::Lt(reach, zero));
    uint64_t hits = ~Bits(misses) & ((uint64_t{1} << lanes) - 1);
    for (; hits != 0; hits &= hits - 1) {
      out[count++] = packets[first + hwy::Num0BitsBelowLS1Bit_Nonzero64(hits)];
    }
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_PAPER_CONIC_PACKETS_INL_H_
