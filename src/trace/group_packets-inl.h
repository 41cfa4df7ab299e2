// What the program's functions see of a group: packets of as many lanes as the call wants, in which
// each ray stands where it stands in the group. Rays are written once; CallbackPacket for groups.

#if defined(DACRT_TRACE_GROUP_PACKETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_PACKETS_INL_H_
#undef DACRT_TRACE_GROUP_PACKETS_INL_H_
#else
#define DACRT_TRACE_GROUP_PACKETS_INL_H_
#endif

#include <cstring>

#include "trace/group_hits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <size_t kMost>
class GroupPackets {
 public:
  /// Whether a group can be handed out so: packets are aligned, and fill the group.
  static bool CanBe(size_t width) { return width == 4 || width == 8 || width == 16; }

  /// The rays of a group, whose numbers are those of their lanes; `all` are the lanes that hold one.
  GroupPackets(const TraceTask& task, const GroupLanes<kMost>& group, LaneMask all)
      : task_(task),
        width_(task.frame.options.callback_width),
        lanes_(HWY_MAX(group.parts() * Lanes(), width_)) {
    using enum PacketComponent;
    // Lanes without a ray hold nothing that is not zero.
    const auto put = [&](PacketComponent component, const float* values) HWY_ATTR {
      HWY_ALIGN float of_rays[kMost];
      for (size_t first = 0; first < lanes_; first += Lanes()) {
        hn::Store(hn::IfThenElseZero(MaskOf(all >> first), hn::Load(kFloat, values + first)),
                  kFloat, of_rays + first);
      }
      ForEachPacket([&](size_t first) {
        memcpy(Values(first, component), of_rays + first, width_ * sizeof(float));
      });
    };
    put(kOrgX, group.org[0]);
    put(kOrgY, group.org[1]);
    put(kOrgZ, group.org[2]);
    put(kTnear, group.tnear);
    put(kDirX, group.dir[0]);
    put(kDirY, group.dir[1]);
    put(kDirZ, group.dir[2]);
    put(kTime, group.time);
    put(kMask, reinterpret_cast<const float*>(group.mask));
    HWY_ALIGN uint32_t ids[kMost], flags[kMost];
    ForEachLane(all, [&](size_t lane) {
      const uint32_t caller = task.CallerOf(static_cast<RayNumber>(lane));
      const RayTag tag = task.frame.Tag(caller);
      ids[lane] = tag.id;
      flags[lane] = tag.flags;
    });
    put(kId, reinterpret_cast<const float*>(ids));
    put(kFlags, reinterpret_cast<const float*>(flags));
  }

  /// Calls a function of a geometry for the rays of some lanes, with these ends and hits. Returns
  /// the lanes that it leaves valid. `change(lane, hit)` is called for those of which it has changed
  /// the end or the hit.
  template <class Change>
  LaneMask Call(const Callback& function, Query query, const GeometryTable::Name& item,
                LaneMask lanes, const float* tfar, const GroupHits<kMost>& hits,
                const Change& change) {
    LaneMask valid = 0;
    ForEachPacket([&](size_t first) {
      const LaneMask of_packet = lanes >> first & FirstLanes(width_);
      if (of_packet != 0) valid |= CallOne(function, query, item, of_packet, first, tfar, hits,
                                           change) << first;
    });
    return valid;
  }

 private:
  template <class Function>
  HWY_INLINE void ForEachPacket(const Function& function) const {
    for (size_t first = 0; first < lanes_; first += width_) function(first);
  }

  /// The values of a component in the packet that begins with a lane.
  HWY_INLINE float* Values(size_t first, PacketComponent component) {
    return values_ + first * kPacketComponents + static_cast<size_t>(component) * width_;
  }

  template <class Change>
  HWY_INLINE LaneMask CallOne(const Callback& function, Query query,
                              const GeometryTable::Name& item, LaneMask lanes, size_t first,
                              const float* tfar, const GroupHits<kMost>& hits,
                              const Change& change) {
    using enum PacketComponent;
    const auto put = [&](PacketComponent component, const auto* values) {
      memcpy(Values(first, component), values + first, width_ * sizeof(float));
    };
    put(kTfar, tfar);
    put(kNgX, hits.ng[0]);
    put(kNgY, hits.ng[1]);
    put(kNgZ, hits.ng[2]);
    put(kU, hits.u);
    put(kV, hits.v);
    put(kPrimitiveId, hits.primitive_id);
    put(kGeometryId, hits.geometry_id);
    put(kInstanceId, hits.instance_id);
    // As it was, from the rays' ends on.
    constexpr auto kBegin = static_cast<size_t>(kTfar);
    const float* const packet = Values(first, kOrgX);
    alignas(64) float before[kPacketComponents * kMostWidth];
    const size_t begin = kBegin * width_;
    const size_t bytes = (kPacketComponents - kBegin) * width_ * sizeof(float);
    memcpy(before + begin, packet + begin, bytes);
    alignas(64) int32_t valid[kMostWidth];
    for (size_t i = 0; i < width_; ++i) valid[i] = -static_cast<int32_t>(lanes >> i & 1);
    function({query, static_cast<uint32_t>(width_), valid, Values(first, kOrgX),
              task_.scene.geometries[item.geometry].geometry_id, item.primitive, task_.instance_id,
              task_.frame.options.call});
    LaneMask left = 0;
    ForEachLane(lanes, [&](size_t i) { left |= LaneMask{valid[i] != 0} << i; });
    if (HWY_LIKELY(memcmp(before + begin, packet + begin, bytes) == 0)) return left;
    ForEachLane(lanes, [&](size_t i) {
      const FullHit now = RecordLayout::ReadHit(packet, width_, i);
      if (!IsSame(now, RecordLayout::ReadHit(before, width_, i))) change(first + i, now);
    });
    return left;
  }

  static constexpr size_t kMostWidth = 16;

  alignas(64) float values_[kPacketComponents * kMost];
  const TraceTask& task_;
  const size_t width_;
  const size_t lanes_;  ///< of packets that may hold rays
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_PACKETS_INL_H_
