// Up to 64 rays in the lanes of vectors.

#if defined(DACRT_TRACE_GROUP_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_LANES_INL_H_
#undef DACRT_TRACE_GROUP_LANES_INL_H_
#else
#define DACRT_TRACE_GROUP_LANES_INL_H_
#endif

#include <cstring>

#include "geometry/four_by_four-inl.h"
#include "geometry/lone_box-inl.h"
#include "geometry/ray_box-inl.h"
#include "geometry/wide_node-inl.h"
#include "rays/load_records-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

/// Rays of the largest groups, and of those that are packets.
constexpr size_t kMostGroupRays = 64, kPacketRays = 16;

/// Lanes of a group, a bit each.
using LaneMask = uint64_t;
/// Bits for the first `count` lanes of a group.
constexpr LaneMask FirstLanes(size_t count) { return ~LaneMask{0} >> (64 - count); }

/// Some vectors of a group.
struct PartRange {
  size_t begin, end;
};

/// The rays of a group as structure of arrays. Lanes without a ray are never looked at, but hold
/// one.
template <size_t kMost>
struct GroupLanes {
  static constexpr size_t kMostParts = kMost / hn::MaxLanes(D());

  HWY_ALIGN float org[3][kMost];
  HWY_ALIGN float reciprocal[3][kMost];
  HWY_ALIGN float dir[3][kMost];
  HWY_ALIGN float start[kMost];
  HWY_ALIGN float tnear[kMost];
  HWY_ALIGN float tfar[kMost];
  HWY_ALIGN float time[kMost];
  HWY_ALIGN uint32_t mask[kMost];
  HWY_ALIGN uint32_t state[kMost];
  HWY_ALIGN uint32_t hit[kMost];

  /// What the triangle test found for lanes whose state says RayRecord::kInLanes; of other hits it
  /// is computed once more at the end.
  HWY_ALIGN float t[kMost];
  HWY_ALIGN float u[kMost];  ///< times den
  HWY_ALIGN float v[kMost];
  HWY_ALIGN float den[kMost];
  HWY_ALIGN float ng[3][kMost];

  /// Vectors in which rays stand: the first ones.
  HWY_INLINE size_t parts() const { return kMostParts == 1 ? 1 : parts_; }
  /// Says that rays stand in the first `count` lanes.
  HWY_INLINE void SetCount(size_t count) { parts_ = (count + Lanes() - 1) / Lanes(); }

  /// Those from the first to the last that hold one of some lanes, of which there is one.
  static HWY_INLINE PartRange PartsWith(LaneMask lanes) {
    if constexpr (kMostParts == 1) return {0, 1};
    return {hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes) / Lanes(),
            (63 - hwy::Num0BitsAboveMS1Bit_Nonzero64(lanes)) / Lanes() + 1};
  }

  /// From the engine's record.
  void Load(size_t lane, const RayRecord& ray) {
    for (int axis = 0; axis < 3; ++axis) {
      org[axis][lane] = ray.org[axis];
      reciprocal[axis][lane] = ray.reciprocal[axis];
      dir[axis][lane] = ray.dir[axis];
    }
    start[lane] = ray.start;
    tnear[lane] = ray.tnear;
    time[lane] = ray.time;
    mask[lane] = ray.mask;
    LoadHit(lane, ray);
  }
  void LoadHit(size_t lane, const RayRecord& ray) {
    tfar[lane] = ray.tfar;
    state[lane] = ray.state;
    hit[lane] = ray.hit;
  }
  void Store(size_t lane, RayRecord& ray) const {
    for (int axis = 0; axis < 3; ++axis) {
      ray.org[axis] = org[axis][lane];
      ray.reciprocal[axis] = reciprocal[axis][lane];
      ray.dir[axis] = dir[axis][lane];
    }
    ray.start = start[lane];
    ray.tnear = tnear[lane];
    ray.time = time[lane];
    ray.mask = mask[lane];
    StoreHit(lane, ray);
  }
  void StoreHit(size_t lane, RayRecord& ray) const {
    ray.tfar = tfar[lane];
    ray.state = state[lane];
    ray.hit = hit[lane];
  }

  /// From the lanes of a packet in the caller's memory. Returns which rays are active, a bit each.
  HWY_INLINE LaneMask LoadPacket(const RayPacket& packet) {
    switch (packet.lanes) {
      case 16:
        return LoadPacketOf<16>(packet);
      case 8:
        return LoadPacketOf<8>(packet);
      case 4:
        return LoadPacketOf<4>(packet);
      default:
        return LoadPacketOf<0>(packet);
    }
  }

  /// From rays of a view, from `first` on.
  HWY_INLINE LaneMask LoadView(const RecordLayout& layout, size_t first, size_t count) {
    if (HWY_LIKELY(layout.has_records())) {
      size_t lane = 0;
#if HWY_TARGET != HWY_SCALAR
      for (; lane + 4 <= count; lane += 4) LoadFourRecords(layout, first + lane, lane);
#endif
      for (; lane < count; ++lane) {
        LoadRecordLane(layout.Record(first + lane), layout.has_masks(), lane);
      }
    } else {
      for (size_t lane = 0; lane < count;) {
#if HWY_TARGET != HWY_SCALAR
        if (lane + 4 <= count && layout.AreSideBySide(first + lane, 4)) {
          LoadFourColumns(layout, first + lane, lane);
          lane += 4;
          continue;
        }
#endif
        LoadViewLane(layout, first + lane, lane);
        ++lane;
      }
    }
    SetCount(count);
    return FinishLanes(FirstLanes(count));
  }

  HWY_INLINE void LoadPart(size_t part, V* o, V* r) const {
    for (int axis = 0; axis < 3; ++axis) {
      o[axis] = hn::Load(kFloat, org[axis] + part * Lanes());
      r[axis] = hn::Load(kFloat, reciprocal[axis] + part * Lanes());
    }
  }

  /// Those of `lanes` whose directions run in the octant of the first of them, which is set.
  HWY_INLINE LaneMask LanesOfOctant(LaneMask lanes, uint32_t& octant) const {
    const size_t first = hwy::Num0BitsBelowLS1Bit_Nonzero64(lanes);
    octant = 0;
    for (int axis = 0; axis < 3; ++axis) {
      uint64_t negative = 0;
      for (size_t part = 0; part < parts(); ++part) {
        negative |=
            Bits(hn::Lt(hn::Load(kFloat, reciprocal[axis] + part * Lanes()), hn::Zero(kFloat)))
            << (part * Lanes());
      }
      const bool is_negative = (negative >> first) & 1;
      octant |= static_cast<uint32_t>(is_negative) << axis;
      lanes &= is_negative ? negative : ~negative;
    }
    return lanes;
  }

  /// Whether some lanes are all that the vectors have in which rays stand.
  HWY_INLINE bool AreAll(LaneMask lanes) const { return lanes == FirstLanes(parts() * Lanes()); }

  /// Those of some lanes whose rays have one of the bits of `geometry_mask` in their masks.
  HWY_INLINE LaneMask Accepting(uint32_t geometry_mask, LaneMask lanes) const {
    LaneMask accepting = 0;
    const PartRange used = PartsWith(lanes);
    for (size_t part = used.begin; part < used.end; ++part) {
      const size_t first = part * Lanes();
      const auto common = hn::And(hn::Load(kUint, mask + first), hn::Set(kUint, geometry_mask));
      accepting |= Bits(hn::RebindMask(kFloat, hn::Ne(common, hn::Zero(kUint)))) << first;
    }
    return lanes & accepting;
  }

  /// Bits that the masks of some lanes' rays have in common.
  HWY_INLINE uint32_t CommonMask(LaneMask lanes) const {
    const auto all = hn::Set(kUint, UINT32_MAX);
    auto common = all;
    for (size_t part = 0; part < parts(); ++part) {
      const auto takes_part = hn::RebindMask(kUint, MaskOf(lanes >> (part * Lanes())));
      common =
          hn::And(common, hn::IfThenElse(takes_part, hn::Load(kUint, mask + part * Lanes()), all));
    }
    HWY_ALIGN uint32_t masks[hn::MaxLanes(DU())];
    hn::Store(common, kUint, masks);
    uint32_t of_all = UINT32_MAX;
    for (const uint32_t one : masks) of_all &= one;
    return of_all;
  }

  HWY_INLINE float LargestTFar(LaneMask lanes) const {
    V largest = hn::Zero(kFloat);
    const PartRange used = PartsWith(lanes);
    for (size_t part = used.begin; part < used.end; ++part) {
      largest =
          hn::Max(largest, hn::IfThenElseZero(MaskOf(lanes >> (part * Lanes())),
                                              hn::Load(kFloat, tfar + part * Lanes())));
    }
    return hn::GetLane(hn::MaxOfLanes(kFloat, largest));
  }

  /// Those of some lanes, of which there is one, that have no hit closer than `distance`.
  HWY_INLINE LaneMask WithEndsFrom(float distance, LaneMask lanes) const {
    LaneMask within = 0;
    const PartRange used = PartsWith(lanes);
    for (size_t part = used.begin; part < used.end; ++part) {
      const V end = hn::Load(kFloat, tfar + part * Lanes());
      within |= Bits(hn::Ge(end, hn::Set(kFloat, distance))) << (part * Lanes());
    }
    return lanes & within;
  }

  /// Those of some lanes whose state has a bit.
  HWY_INLINE LaneMask LanesInState(LaneMask lanes, uint32_t bit) const {
    uint64_t having = 0;
    for (size_t part = 0; part < parts(); ++part) {
      const auto of_part = hn::Load(kUint, state + part * Lanes());
      const auto has_bit = hn::TestBit(of_part, hn::Set(kUint, bit));
      having |= Bits(hn::RebindMask(kFloat, has_bit)) << (part * Lanes());
    }
    return lanes & having;
  }

  /// Those of some lanes whose any-hit rays are blocked.
  HWY_INLINE LaneMask Blocked(LaneMask lanes) const {
    uint64_t blocked = 0;
    for (size_t part = 0; part < parts(); ++part) {
      const V end = hn::Load(kFloat, tfar + part * Lanes());
      blocked |= Bits(hn::Lt(end, hn::Zero(kFloat))) << (part * Lanes());
    }
    return lanes & blocked;
  }

 private:
#if HWY_TARGET != HWY_SCALAR
  /// Records `first` to `first + 3`, into lanes from `lane` on.
  HWY_INLINE void LoadFourRecords(const RecordLayout& layout, size_t first, size_t lane) {
    using enum PacketComponent;
    const float* records[4];
    for (size_t i = 0; i < 4; ++i) records[i] = layout.Record(first + i);
    const auto load = [&](PacketComponent component, float* x, float* y, float* z,
                          float* w) HWY_ATTR {
      auto rows = FourByFour<CornerTag>::Load(
          [&](size_t i) { return records[i] + static_cast<size_t>(component); });
      rows.Transpose();
      hn::Store(rows.v[0], kCornerTag, x + lane);
      hn::Store(rows.v[1], kCornerTag, y + lane);
      hn::Store(rows.v[2], kCornerTag, z + lane);
      hn::Store(rows.v[3], kCornerTag, w + lane);
    };
    load(kOrgX, org[0], org[1], org[2], tnear);
    load(kDirX, dir[0], dir[1], dir[2], time);
    // What stands behind the mask may not be the record's.
    for (size_t i = 0; i < 4; ++i) {
      tfar[lane + i] = records[i][static_cast<size_t>(kTfar)];
      mask[lane + i] = UINT32_MAX;
      if (layout.has_masks()) {
        memcpy(&mask[lane + i], records[i] + static_cast<size_t>(kMask), sizeof(uint32_t));
      }
    }
  }
#endif

  HWY_INLINE void LoadRecordLane(const float* record, bool has_mask, size_t lane) {
    using enum PacketComponent;
    const auto read = [&](PacketComponent component) {
      return record[static_cast<size_t>(component)];
    };
    org[0][lane] = read(kOrgX);
    org[1][lane] = read(kOrgY);
    org[2][lane] = read(kOrgZ);
    tnear[lane] = read(kTnear);
    dir[0][lane] = read(kDirX);
    dir[1][lane] = read(kDirY);
    dir[2][lane] = read(kDirZ);
    time[lane] = read(kTime);
    tfar[lane] = read(kTfar);
    mask[lane] = UINT32_MAX;
    if (has_mask) memcpy(&mask[lane], record + static_cast<size_t>(kMask), sizeof(uint32_t));
  }

#if HWY_TARGET != HWY_SCALAR
  /// Rays `first` to `first + 3`, of which each component is an array, into the lanes from `lane`
  /// on.
  HWY_INLINE void LoadFourColumns(const RecordLayout& layout, size_t first, size_t lane) {
    const RayView& view = layout.view();
    const std::uintptr_t start = layout.StartOf(first);
    const hn::RebindToUnsigned<CornerTag> d;
    const auto load = [&](RayView::Component component, uint32_t absent, auto* to) HWY_ATTR {
      auto values = hn::Set(d, absent);
      if (component != RayView::kAbsent) {
        values = hn::LoadU(d, reinterpret_cast<const uint32_t*>(start + component));
      }
      hn::StoreU(values, d, reinterpret_cast<uint32_t*>(to + lane));
    };
    load(view.org_x, 0, org[0]);
    load(view.org_y, 0, org[1]);
    load(view.org_z, 0, org[2]);
    load(view.tnear, 0, tnear);
    load(view.dir_x, 0, dir[0]);
    load(view.dir_y, 0, dir[1]);
    load(view.dir_z, 0, dir[2]);
    load(view.time, 0, time);
    load(view.tfar, 0, tfar);
    load(view.mask, UINT32_MAX, mask);
  }
#endif

  /// The same for a lane, wherever components stand.
  HWY_INLINE void LoadViewLane(const RecordLayout& layout, size_t i, size_t lane) {
    RayRecord ray;
    layout.Read(i, ray);
    for (int axis = 0; axis < 3; ++axis) {
      org[axis][lane] = ray.org[axis];
      dir[axis][lane] = ray.dir[axis];
    }
    tnear[lane] = ray.tnear;
    tfar[lane] = ray.tfar;
    time[lane] = ray.time;
    mask[lane] = ray.mask;
  }

  /// The first kCount of some values, and zeros behind them where the vector is longer. Not with a
  /// mask: processors that have no more than AVX2 may take as long for such a load as for a packet.
  template <size_t kCount, class Tag>
  static HWY_INLINE hn::Vec<Tag> LoadFirst(Tag d, const float* values) {
#if HWY_TARGET != HWY_SCALAR
    if constexpr (hn::MaxLanes(Tag()) > kCount) {
      return hn::ZeroExtendVector(d, LoadFirst<kCount>(hn::Half<Tag>(), values));
    }
#endif
    return hn::LoadU(d, values);
  }

  /// kCount is the packet's lanes, or 0 if that is not known.
  template <size_t kCount>
  HWY_INLINE LaneMask LoadPacketOf(const RayPacket& packet) {
    using enum PacketComponent;
    const size_t count = kCount ? kCount : packet.lanes;
    const float* const values = static_cast<const float*>(packet.values);
    const auto read = [&](PacketComponent component, void* to) HWY_ATTR {
      const float* const row = values + static_cast<size_t>(component) * count;
      if constexpr (kCount == 0) {
        memcpy(to, row, count * sizeof(float));
      } else {
        // Full vectors are loaded next, which would have to wait for one that is stored in parts.
        for (size_t lane = 0; lane < kCount; lane += Lanes()) {
          hn::Store(LoadFirst<kCount>(kFloat, row + lane), kFloat, static_cast<float*>(to) + lane);
        }
      }
    };
    read(kOrgX, org[0]);
    read(kOrgY, org[1]);
    read(kOrgZ, org[2]);
    read(kTnear, tnear);
    read(kDirX, dir[0]);
    read(kDirY, dir[1]);
    read(kDirZ, dir[2]);
    read(kTime, time);
    read(kTfar, tfar);
    if (packet.has_masks) {
      read(kMask, mask);
    } else {
      memset(mask, 0xFF, sizeof(mask));
    }
    SetCount(count);
    return FinishLanes(packet.valid ? ValidLanes<kCount>(packet.valid, count) : FirstLanes(count));
  }

  /// Those of `count` lanes, which is kCount unless that is 0, whose value is -1.
  template <size_t kCount>
  static HWY_INLINE LaneMask ValidLanes(const int32_t* values, size_t count) {
    LaneMask valid = 0;
    if constexpr (kCount == 0) {
      for (size_t lane = 0; lane < count; ++lane) valid |= LaneMask{values[lane] == -1} << lane;
    } else {
      const hn::CappedTag<float, kCount> d;
      const hn::RebindToSigned<decltype(d)> di;
      for (size_t lane = 0; lane < kCount; lane += hn::MaxLanes(d)) {
        const auto is_valid = hn::Eq(hn::LoadU(di, values + lane), hn::Set(di, -1));
        valid |= Bits(d, hn::RebindMask(d, is_valid)) << lane;
      }
    }
    return valid;
  }

  /// Sets what is derived from the values of lanes that hold a ray. Returns those that are active,
  /// by the definition in RayView.
  HWY_INLINE LaneMask FinishLanes(LaneMask lanes) {
    LaneMask active = 0;
    for (size_t part = 0; part < parts(); ++part) {
      const size_t first = part * Lanes();
      const V zero = hn::Zero(kFloat);
      const V begin = hn::Load(kFloat, tnear + first), end = hn::Load(kFloat, tfar + first);
      // x - x is 0 unless x is infinite or not a number.
      M is_active = hn::And(hn::Le(begin, end), hn::Ge(end, zero));
      for (int axis = 0; axis < 3; ++axis) {
        const V o = hn::Load(kFloat, org[axis] + first), d = hn::Load(kFloat, dir[axis] + first);
        is_active =
            hn::And(is_active, hn::And(hn::Eq(hn::Sub(o, o), zero), hn::Eq(hn::Sub(d, d), zero)));
        hn::Store(SafeReciprocal(d), kFloat, reciprocal[axis] + first);
      }
      const auto has_mask = hn::Ne(hn::Load(kUint, mask + first), hn::Zero(kUint));
      is_active = hn::And(is_active, hn::RebindMask(kFloat, has_mask));
      active |= Bits(is_active) << first;
      hn::Store(hn::IfThenElse(is_active, end, hn::Set(kFloat, -1.0f)), kFloat, tfar + first);
      // As RayRecord::StartOf: of -0 and 0 the second counts.
      hn::Store(hn::Max(begin, zero), kFloat, start + first);
      hn::Store(hn::Set(kUint, uint32_t{RayRecord::kAtLimit}), kUint, state + first);
    }
    active &= lanes;
    return active;
  }

  size_t parts_ = kMostParts;
};

/// The ray of a lane, in all lanes of a vector.
template <size_t kMost>
struct SpreadLane {
  const GroupLanes<kMost>& lanes;
  size_t lane;

  HWY_INLINE EightPart org(int axis) const { return hn::Set(kEightTag, lanes.org[axis][lane]); }
  HWY_INLINE EightPart dir(int axis) const { return hn::Set(kEightTag, lanes.dir[axis][lane]); }
  HWY_INLINE EightPart reciprocal(int axis) const {
    return hn::Set(kEightTag, lanes.reciprocal[axis][lane]);
  }
  HWY_INLINE EightPart start() const { return hn::Set(kEightTag, lanes.start[lane]); }
  HWY_INLINE EightPart tnear() const { return hn::Set(kEightTag, lanes.tnear[lane]); }
  HWY_INLINE EightPart tfar() const { return hn::Set(kEightTag, lanes.tfar[lane]); }

#if HWY_TARGET != HWY_SCALAR
  HWY_INLINE LoneLine line() const {
    return {LoadAcross(&lanes.org[0][lane], kMost), LoadAcross(&lanes.reciprocal[0][lane], kMost),
            lanes.tnear[lane]};
  }
#endif
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_LANES_INL_H_
