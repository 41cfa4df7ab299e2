// Rays and hits from the engine's records to the packets that callbacks see, and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "rays/record_layout.h"
#include "trace/trace_task.h"

namespace dacrt {

/// A packet on the stack, so that callbacks may trace rays themselves.
class alignas(64) CallbackPacket {
 public:
  static constexpr std::size_t kMostLanes = 16;

  explicit CallbackPacket(const TraceTask& task)
      : task_(task), width_(task.frame.options.callback_width) {}

  /// The lane of a ray, which is one of those that are shown together, by its turn among them: of a
  /// packet of the caller's each ray stays in its lane, rays of a stream have none.
  std::size_t LaneOf(RayNumber ray, std::size_t turn) const {
    return task_.frame.ray_count() <= width_ ? task_.CallerOf(ray) % width_ : turn;
  }

  /// Nothing in any lane.
  void Clear() {
    std::memset(valid, 0, sizeof(valid));
    std::memset(values_, 0, kPacketComponents * width_ * sizeof(uint32_t));
  }

  /// A ray, which goes on to `tfar`, into a lane.
  void SetRay(std::size_t lane, RayNumber number, float tfar) {
    using enum PacketComponent;
    const RayRecord& ray = task_.rays[number];
    const RayTag tag = task_.TagOf(number);
    Set(kOrgX, lane, ray.org[0]);
    Set(kOrgY, lane, ray.org[1]);
    Set(kOrgZ, lane, ray.org[2]);
    Set(kTnear, lane, ray.tnear);
    Set(kDirX, lane, ray.dir[0]);
    Set(kDirY, lane, ray.dir[1]);
    Set(kDirZ, lane, ray.dir[2]);
    Set(kTime, lane, ray.time);
    Set(kTfar, lane, tfar);
    Set(kMask, lane, ray.mask);
    Set(kId, lane, tag.id);
    Set(kFlags, lane, tag.flags);
  }
  void SetHit(std::size_t lane, const FullHit& hit) {
    using enum PacketComponent;
    Set(kNgX, lane, hit.ng[0]);
    Set(kNgY, lane, hit.ng[1]);
    Set(kNgZ, lane, hit.ng[2]);
    Set(kU, lane, hit.u);
    Set(kV, lane, hit.v);
    Set(kPrimitiveId, lane, hit.primitive_id);
    Set(kGeometryId, lane, hit.geometry_id);
    Set(kInstanceId, lane, hit.instance_id);
  }
  /// With the ray's distance.
  FullHit GetHit(std::size_t lane) const { return RecordLayout::ReadHit(values_, width_, lane); }

  /// What a callback for a geometry is called with.
  CallbackArguments Arguments(Query query, uint32_t geometry, uint32_t primitive_id) {
    return {query,
            static_cast<uint32_t>(width_),
            valid,
            values_,
            task_.scene.geometries[geometry].geometry_id,
            primitive_id,
            task_.instance_id,
            task_.frame.options.call};
  }

  int32_t valid[kMostLanes];

 private:
  template <class T>
  void Set(PacketComponent component, std::size_t lane, T value) {
    static_assert(sizeof(T) == sizeof(uint32_t));
    std::memcpy(&values_[static_cast<std::size_t>(component) * width_ + lane], &value,
                sizeof(value));
  }

  alignas(64) uint32_t values_[kPacketComponents * kMostLanes];
  const TraceTask& task_;
  const std::size_t width_;
};

}  // namespace dacrt
