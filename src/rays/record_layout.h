// Reading and writing the caller's records: the only place of the recursion over the kept partition
// that knows how they lie.
#pragma once

#include <hwy/base.h>
#include <hwy/cache_control.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "dacrt/callback.h"
#include "dacrt/ray_view.h"
#include "rays/ray_record.h"

namespace dacrt {

/// A view of rays, seen through once: most are records one behind the other, in the order of
/// PacketComponent.
class RecordLayout {
 public:
  explicit RecordLayout(const RayView& view) : view_(view) {
    const auto follows = [&](RayView::Component component, PacketComponent place) {
      return component == view.org_x + sizeof(float) * static_cast<std::size_t>(place);
    };
    using enum PacketComponent;
    has_records_ = view.lanes == 1 && follows(view.org_y, kOrgY) && follows(view.org_z, kOrgZ) &&
                   follows(view.tnear, kTnear) && follows(view.dir_x, kDirX) &&
                   follows(view.dir_y, kDirY) && follows(view.dir_z, kDirZ) &&
                   follows(view.time, kTime) && follows(view.tfar, kTfar) &&
                   (follows(view.mask, kMask) || view.mask == RayView::kAbsent);
    has_hit_records_ = has_records_ && follows(view.ng_x, kNgX) && follows(view.ng_y, kNgY) &&
                       follows(view.ng_z, kNgZ) && follows(view.u, kU) && follows(view.v, kV) &&
                       follows(view.primitive_id, kPrimitiveId) &&
                       follows(view.geometry_id, kGeometryId) &&
                       follows(view.instance_id, kInstanceId);
  }

  /// Whether rays are records in the order of PacketComponent.
  bool has_records() const { return has_records_; }
  /// The record of a ray, then.
  float* Record(std::size_t i) const { return reinterpret_cast<float*>(StartOf(i) + view_.org_x); }
  /// Whether their hits stand there too.
  bool has_hit_records() const { return has_hit_records_; }
  bool has_masks() const { return view_.mask != RayView::kAbsent; }

  /// Asks for the memory of a ray that will soon be read or written, if it is such a record: what
  /// the processor fetches by itself comes late where tracing stands between one ray and the next.
  HWY_INLINE void Prefetch(std::size_t i) const {
    if (!has_records_) return;
    using enum PacketComponent;
    const float* const record = Record(i);
    hwy::Prefetch(record);
    hwy::Prefetch(record + static_cast<std::size_t>(has_hit_records_ ? kInstanceId : kTfar));
  }

  /// What the components of a ray stand behind: looked up once for all of them.
  std::uintptr_t StartOf(std::size_t i) const { return view_.Address(0, i); }

  /// Whether each component of rays `i` to `i + count - 1` is an array.
  bool AreSideBySide(std::size_t i, std::size_t count) const {
    if (view_.lanes == 1) return !view_.packets && view_.packet_stride == sizeof(float);
    return view_.lane_stride == sizeof(float) && view_.Packet(i) == view_.Packet(i + count - 1);
  }
  const RayView& view() const { return view_; }

  /// A bit for each axis on which the direction is negative.
  uint32_t ReadOctant(std::size_t i) const {
    const std::uintptr_t start = StartOf(i);
    const auto sign = [&](RayView::Component component) {
      return ReadBehind(start, component, uint32_t{0}) >> 31;
    };
    return sign(view_.dir_x) | sign(view_.dir_y) << 1 | sign(view_.dir_z) << 2;
  }

  /// Reads what the engine's record of a ray is made of, component by component.
  void Read(std::size_t i, RayRecord& ray) const {
    const std::uintptr_t start = StartOf(i);
    const auto read = [&](RayView::Component component, auto absent) {
      return ReadBehind(start, component, absent);
    };
    ray.org[0] = read(view_.org_x, 0.0f);
    ray.org[1] = read(view_.org_y, 0.0f);
    ray.org[2] = read(view_.org_z, 0.0f);
    ray.tnear = read(view_.tnear, 0.0f);
    ray.dir[0] = read(view_.dir_x, 0.0f);
    ray.dir[1] = read(view_.dir_y, 0.0f);
    ray.dir[2] = read(view_.dir_z, 0.0f);
    ray.time = read(view_.time, 0.0f);
    ray.tfar = read(view_.tfar, 0.0f);
    ray.mask = read(view_.mask, UINT32_MAX);
  }

  /// The same from a record in the order of PacketComponent.
  static void ReadRecord(const float* record, RayRecord& ray) {
    using enum PacketComponent;
    std::memcpy(ray.org, record, sizeof(ray.org));
    ray.tnear = record[static_cast<std::size_t>(kTnear)];
    std::memcpy(ray.dir, record + static_cast<std::size_t>(kDirX), sizeof(ray.dir));
    ray.time = record[static_cast<std::size_t>(kTime)];
    ray.tfar = record[static_cast<std::size_t>(kTfar)];
    std::memcpy(&ray.mask, record + static_cast<std::size_t>(kMask), sizeof(ray.mask));
  }

  /// What was said of the ray of a packet's lane.
  static HWY_INLINE void ReadLane(const RayPacket& packet, std::size_t lane, RayRecord& ray) {
    using enum PacketComponent;
    const float* const values = static_cast<const float*>(packet.values) + lane;
    const auto value = [&](PacketComponent component) {
      return values[static_cast<std::size_t>(component) * packet.lanes];
    };
    ray.org[0] = value(kOrgX);
    ray.org[1] = value(kOrgY);
    ray.org[2] = value(kOrgZ);
    ray.tnear = value(kTnear);
    ray.dir[0] = value(kDirX);
    ray.dir[1] = value(kDirY);
    ray.dir[2] = value(kDirZ);
    ray.time = value(kTime);
    ray.tfar = value(kTfar);
    ray.mask = packet.has_masks ? std::bit_cast<uint32_t>(value(kMask)) : UINT32_MAX;
  }

  static void WriteBlocked(const RayPacket& packet, uint32_t lane) {
    WriteTFar(packet, lane, -std::numeric_limits<float>::infinity());
  }
  static void WriteLane(const RayPacket& packet, uint32_t lane, const FullHit& hit) {
    float values[offsetof(FullHit, t) / sizeof(float)];
    std::memcpy(values, &hit, sizeof(values));
    WriteTFar(packet, lane, hit.t);
    float* out = static_cast<float*>(packet.values) +
                 static_cast<std::size_t>(PacketComponent::kNgX) * packet.lanes + lane;
    for (const float value : values) {
      std::memcpy(out, &value, sizeof(value));
      out += packet.lanes;
    }
  }

  void WriteBlocked(std::size_t i) const {
    WriteBehind(StartOf(i), view_.tfar, -std::numeric_limits<float>::infinity());
  }

  HWY_INLINE void WriteHit(std::size_t i, const FullHit& hit) const {
    if (has_hit_records_) {
      return WriteRecord(hit, Record(i));
    }
    WriteComponents(i, hit);
  }

  /// To a record in the order of PacketComponent. Value by value, and inlined: what was just
  /// computed goes from registers to the record.
  static HWY_INLINE void WriteRecord(const FullHit& hit, float* record) {
    using enum PacketComponent;
    const auto write = [&](PacketComponent component, auto value) {
      static_assert(sizeof(value) == sizeof(float));
      std::memcpy(record + static_cast<std::size_t>(component), &value, sizeof(value));
    };
    write(kTfar, hit.t);
    write(kNgX, hit.ng[0]);
    write(kNgY, hit.ng[1]);
    write(kNgZ, hit.ng[2]);
    write(kU, hit.u);
    write(kV, hit.v);
    write(kPrimitiveId, hit.primitive_id);
    write(kGeometryId, hit.geometry_id);
    write(kInstanceId, hit.instance_id);
  }

  /// The hit of a lane of a packet of `width` lanes in the order of PacketComponent.
  static HWY_INLINE FullHit ReadHit(const void* packet, std::size_t width, std::size_t lane) {
    using enum PacketComponent;
    const auto read = [&](PacketComponent component, auto& value) {
      static_assert(sizeof(value) == sizeof(float));
      std::memcpy(
          &value,
          static_cast<const float*>(packet) + static_cast<std::size_t>(component) * width + lane,
          sizeof(value));
    };
    FullHit hit;
    read(kNgX, hit.ng[0]);
    read(kNgY, hit.ng[1]);
    read(kNgZ, hit.ng[2]);
    read(kU, hit.u);
    read(kV, hit.v);
    read(kPrimitiveId, hit.primitive_id);
    read(kGeometryId, hit.geometry_id);
    read(kInstanceId, hit.instance_id);
    read(kTfar, hit.t);
    return hit;
  }

  /// A component of ray i, or `absent`.
  template <class T>
  T Read(RayView::Component component, std::size_t i, T absent) const {
    return ReadBehind(StartOf(i), component, absent);
  }

 private:
  HWY_NOINLINE void WriteComponents(std::size_t i, const FullHit& hit) const {
    const std::uintptr_t start = StartOf(i);
    const auto write = [&](RayView::Component component, auto value) {
      WriteBehind(start, component, value);
    };
    write(view_.tfar, hit.t);
    write(view_.ng_x, hit.ng[0]);
    write(view_.ng_y, hit.ng[1]);
    write(view_.ng_z, hit.ng[2]);
    write(view_.u, hit.u);
    write(view_.v, hit.v);
    write(view_.primitive_id, hit.primitive_id);
    write(view_.geometry_id, hit.geometry_id);
    write(view_.instance_id, hit.instance_id);
  }

  static void WriteTFar(const RayPacket& packet, uint32_t lane, float tfar) {
    static_cast<float*>(
        packet.values)[static_cast<std::size_t>(PacketComponent::kTfar) * packet.lanes + lane] =
        tfar;
  }

  template <class T>
  static T ReadBehind(std::uintptr_t start, RayView::Component component, T absent) {
    if (component == RayView::kAbsent) return absent;
    T value;
    std::memcpy(&value, reinterpret_cast<const void*>(start + component), sizeof(value));
    return value;
  }
  template <class T>
  static void WriteBehind(std::uintptr_t start, RayView::Component component, T value) {
    if (component == RayView::kAbsent) return;
    std::memcpy(reinterpret_cast<void*>(start + component), &value, sizeof(value));
  }

  const RayView& view_;
  bool has_records_;
  bool has_hit_records_;
};

}  // namespace dacrt
