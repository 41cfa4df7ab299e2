// What the program's functions see of a group: packets of as many lanes as the call wants, in which
// each ray stands where it stands in the group. Rays are written once; CallbackPacket for groups.

#if defined(DACRT_TRACE_GROUP_PACKETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef DACRT_TRACE_GROUP_PACKETS_INL_H_
#undef DACRT_TRACE_GROUP_PACKETS_INL_H_
#else
#define DACRT_TRACE_GROUP_PACKETS_INL_H_
#endif

#include <type_traits>

#include "trace/group_hits-inl.h"

HWY_BEFORE_NAMESPACE();
namespace dacrt {
namespace HWY_NAMESPACE {

template <size_t kMost>
class GroupPackets {
 public:
  /// Whether a group can be handed out so: packets are aligned, and fill the group.
  static bool CanBe(size_t width) { return width == 4 || width == 8 || width == 16; }

  /// The rays of a group, whose numbers are those of their lanes; `all` are the lanes that hold
  /// one.
  GroupPackets(const TraceTask& task, const GroupLanes<kMost>& group, LaneMask all)
      : task_(task),
        width_(task.frame.options.callback_width),
        lanes_(HWY_MAX(group.parts() * Lanes(), width_)) {
    HWY_ALIGN uint32_t ids[kMost], flags[kMost];
    ForEachLane(all, [&](size_t lane) {
      const RayTag tag = task.TagOf(static_cast<RayNumber>(lane));
      ids[lane] = tag.id;
      flags[lane] = tag.flags;
    });
    WithWidth([&](auto width) HWY_ATTR {
      // Lanes without a ray hold nothing that is not zero.
      const hn::CappedTag<uint32_t, width()> d;
      const hn::RebindToFloat<decltype(d)> df;
      for (size_t first = 0; first < lanes_; first += hn::MaxLanes(d)) {
        const auto has_ray = hn::RebindMask(d, MaskOf(df, all >> first));
        const auto put = [&](PacketComponent component, const auto* values) HWY_ATTR {
          const auto* const from = reinterpret_cast<const uint32_t*>(values) + first;
          hn::Store(hn::IfThenElseZero(has_ray, hn::Load(d, from)), d,
                    Values<width()>(first / width() * width(), component) + first % width());
        };
        using enum PacketComponent;
        put(kOrgX, group.org[0]);
        put(kOrgY, group.org[1]);
        put(kOrgZ, group.org[2]);
        put(kTnear, group.tnear);
        put(kDirX, group.dir[0]);
        put(kDirY, group.dir[1]);
        put(kDirZ, group.dir[2]);
        put(kTime, group.time);
        put(kMask, group.mask);
        put(kId, ids);
        put(kFlags, flags);
        // Hits that are shown one by one stand among lanes that nobody has written.
        const auto clear = [&](PacketComponent component) HWY_ATTR {
          hn::Store(hn::Zero(d), d,
                    Values<width()>(first / width() * width(), component) + first % width());
        };
        clear(kTfar);
        for (auto i = static_cast<size_t>(kNgX); i < kPacketComponents; ++i) {
          clear(static_cast<PacketComponent>(i));
        }
      }
    });
  }

  /// Shows a filter function a hit of the ray in a lane. Returns whether it leaves it valid, and
  /// what it has made of it.
  bool CallAlone(const Callback& filter, Query query, const GeometryTable::Name& item, size_t lane,
                 FullHit& hit) {
    const size_t first = lane / width_ * width_, i = lane - first;
    uint32_t* const packet = values_ + first * kPacketComponents;
    RecordLayout::WriteLane({packet, static_cast<uint32_t>(width_)}, static_cast<uint32_t>(i), hit);
    alignas(64) int32_t valid[kPacketRays] = {};
    valid[i] = -1;
    filter(ArgumentsOf(query, item, valid, packet));
    task_.CountAnswers(valid[i] != 0, 1);
    if (valid[i] == 0) return false;
    hit = RecordLayout::ReadHit(packet, width_, i);
    return true;
  }

  /// What a function has made of the rays of some lanes.
  struct Answers {
    LaneMask valid = 0;    ///< those that it leaves so
    LaneMask changed = 0;  ///< those of which it has changed the end or the hit
    FullHit hits[kMost];   ///< of these, with the end
  };

  /// Calls a function of a geometry for the rays of some lanes, with these ends and hits.
  void Call(const Callback& function, Query query, const GeometryTable::Name& item, LaneMask lanes,
            const float* tfar, const GroupHits<kMost>& hits, Answers& answers) {
    WithWidth([&](auto width) HWY_ATTR {
      for (size_t first = 0; first < lanes_; first += width()) {
        const LaneMask of_packet = lanes >> first & FirstLanes(width());
        if (of_packet == 0) continue;
        CallOne<width()>(function, query, item, of_packet, first, tfar, hits, answers);
      }
    });
  }

 private:
  HWY_INLINE CallbackArguments ArgumentsOf(Query query, const GeometryTable::Name& item,
                                           int32_t* valid, void* packet) const {
    return {query,
            static_cast<uint32_t>(width_),
            valid,
            packet,
            task_.scene.geometries[item.geometry].geometry_id,
            item.primitive,
            task_.instance_id,
            task_.frame.options.call};
  }

  /// Calls `body` with the width as a constant.
  template <class Body>
  HWY_INLINE void WithWidth(const Body& body) const {
    if (width_ == 4) return body(std::integral_constant<size_t, 4>());
    if (width_ == 8) return body(std::integral_constant<size_t, 8>());
    body(std::integral_constant<size_t, 16>());
  }

  /// The values of a component in the packet that begins with a lane.
  template <size_t kWidth>
  HWY_INLINE uint32_t* Values(size_t first, PacketComponent component) {
    return values_ + first * kPacketComponents + static_cast<size_t>(component) * kWidth;
  }

  template <size_t kWidth>
  HWY_INLINE void CallOne(const Callback& function, Query query, const GeometryTable::Name& item,
                          LaneMask lanes, size_t first, const float* tfar,
                          const GroupHits<kMost>& hits, Answers& answers) {
    // Copied in whole vectors, and compared so: what a function may change.
    const hn::CappedTag<uint32_t, kWidth> d;
    uint32_t* const packet = Values<kWidth>(first, PacketComponent::kOrgX);
    const auto for_each = [&](const auto& body) HWY_ATTR {
      hits.ForEachRow(tfar, [&](PacketComponent component, const auto* values) HWY_ATTR {
        uint32_t* const in_packet = packet + static_cast<size_t>(component) * kWidth;
        const auto* const own = reinterpret_cast<const uint32_t*>(values) + first;
        for (size_t i = 0; i < kWidth; i += hn::MaxLanes(d)) body(own + i, in_packet + i);
      });
    };
    for_each([&](const uint32_t* own, uint32_t* in_packet)
                 HWY_ATTR { hn::Store(hn::Load(d, own), d, in_packet); });
    alignas(64) int32_t valid[kWidth];
    for (size_t i = 0; i < kWidth; ++i) valid[i] = -static_cast<int32_t>(lanes >> i & 1);
    function(ArgumentsOf(query, item, valid, packet));
    ForEachLane(lanes, [&](size_t i) { answers.valid |= LaneMask{valid[i] != 0} << (first + i); });
    auto changed = hn::Zero(d);
    for_each([&](const uint32_t* own, uint32_t* in_packet) HWY_ATTR {
      changed = hn::Or(changed, hn::Xor(hn::Load(d, own), hn::Load(d, in_packet)));
    });
    if (HWY_LIKELY(hn::AllTrue(d, hn::Eq(changed, hn::Zero(d))))) return;
    ForEachLane(lanes, [&](size_t i) {
      const FullHit now = RecordLayout::ReadHit(packet, kWidth, i);
      FullHit before = hits.Get(first + i);
      before.t = tfar[first + i];
      if (IsSame(now, before)) return;
      answers.changed |= LaneMask{1} << (first + i);
      answers.hits[first + i] = now;
    });
  }

  alignas(64) uint32_t values_[kPacketComponents * kMost];
  const TraceTask& task_;
  const size_t width_;
  const size_t lanes_;  ///< of packets that may hold rays
};

}  // namespace HWY_NAMESPACE
}  // namespace dacrt
HWY_AFTER_NAMESPACE();

#endif  // DACRT_TRACE_GROUP_PACKETS_INL_H_
