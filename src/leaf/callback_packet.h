// Rays and hits from the engine's records to the packets that callbacks see, and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "trace/trace_task.h"

namespace dacrt {

/// A packet on the stack, so that callbacks may trace rays themselves.
class alignas(64) CallbackPacket {
 public:
  static constexpr std::size_t kMostLanes = 16;

  explicit CallbackPacket(const TraceTask& task)
      : task_(task), width_(task.frame.options.callback_width) {}

  /// Nothing in any lane.
  void Clear() {
    std::memset(valid, 0, sizeof(valid));
    std::memset(values_, 0, kPacketComponents * width_ * sizeof(uint32_t));
  }

  /// Ray `ray`, which goes on to `tfar`, into a lane.
  void SetRay(std::size_t lane, RayNumber ray, float tfar);
  void SetHit(std::size_t lane, const FullHit& hit);
  /// With the ray's distance.
  FullHit GetHit(std::size_t lane) const;

  /// What a callback for a geometry is called with.
  CallbackArguments Arguments(Query query, uint32_t geometry, uint32_t primitive_id);

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
