// Rays and hits from the engine's arrays to the packets that callbacks see, and back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "solve/solve_task.h"

namespace dacrt {

/// Lane `lane` of the packet in the scratch of a task.
class PacketLane {
 public:
  PacketLane(const SolveTask& task, std::size_t lane)
      : values_(task.scratch.packet.values + lane), width_(task.frame->options.callback_width) {}

  template <class T>
  void Set(PacketComponent component, T value) const {
    static_assert(sizeof(T) == sizeof(uint32_t));
    std::memcpy(At(component), &value, sizeof(value));
  }
  template <class T>
  T Get(PacketComponent component) const {
    static_assert(sizeof(T) == sizeof(uint32_t));
    T value;
    std::memcpy(&value, At(component), sizeof(value));
    return value;
  }

  /// The ray in `slot`, which goes on to `tfar`.
  void SetRay(const SolveTask& task, std::size_t slot, float tfar) const;

  void SetHit(const FullHit& hit) const;
  /// All but the distance, which is the ray's.
  FullHit GetHit() const;

 private:
  uint32_t* At(PacketComponent component) const {
    return values_ + static_cast<std::size_t>(component) * width_;
  }

  uint32_t* values_;
  std::size_t width_;
};

/// What a callback for `geometry` is called with.
CallbackArguments ArgumentsFor(const SolveTask& task, Query query, uint32_t geometry,
                               uint32_t primitive_id);

}  // namespace dacrt
