// A device: the engine's device, the errors of its calls, and the callbacks for both.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

#include "config.h"
#include "dacrt/dacrt.h"
#include "dacrt/mpi.h"

namespace dacrt::compat {

/// Threads: any number at once.
class Device : public std::enable_shared_from_this<Device> {
 public:
  explicit Device(const Config& config);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const std::shared_ptr<dacrt::Device>& engine() const { return engine_; }
  bool ignore_masks() const { return ignore_masks_; }

  /// The ranks that work together, if the configuration asks for some.
  const std::shared_ptr<mpi::Group>& ranks() const { return ranks_; }

  /// Whether every rank has its part of each scene, so that all commit together.
  bool is_divided() const { return is_divided_; }

  /// The ID from which on rtcAttachGeometry looks for a free one.
  uint32_t first_geometry_id() const { return first_geometry_id_; }

  /// Tells the program, once and if it wants to hear of such things, that a scene stays on its rank.
  void NoteSceneStays();

  /// Passes an error of the calling thread to the error function, and keeps it until the thread
  /// reads it, unless an earlier one is still unread. Allocates nothing.
  void Report(RTCError code, const char* message);

  /// The calling thread's unread error, which is read now.
  RTCError TakeError();

  void SetErrorFunction(RTCErrorFunction function, void* user_pointer);

  /// Tells the memory monitor that `bytes` will be allocated.
  /// Throws RTC_ERROR_OUT_OF_MEMORY if it refuses.
  void AnnounceAllocation(std::size_t bytes);

  /// Tells the memory monitor that `bytes` were freed.
  void AnnounceFree(std::size_t bytes);

  void SetMemoryMonitorFunction(RTCMemoryMonitorFunction function, void* user_pointer);

  /// Throws RTC_ERROR_INVALID_ARGUMENT for a property that Embree does not know.
  ssize_t Property(RTCDeviceProperty property) const;

 private:
  /// Tells the memory monitor. False if it refuses.
  bool Announce(std::ptrdiff_t bytes);

  template <class Function>
  struct Callback {
    Function function = nullptr;
    void* user_pointer = nullptr;
  };

  const bool ignore_masks_;
  const bool is_verbose_;
  const bool is_divided_;
  const std::shared_ptr<mpi::Group> ranks_;
  const uint32_t first_geometry_id_;
  const uint64_t number_;  ///< that no later device gets
  std::atomic<bool> has_noted_{false};

  mutable std::mutex mutex_;  ///< of everything below
  Callback<RTCErrorFunction> error_callback_;
  Callback<RTCMemoryMonitorFunction> memory_monitor_;

  const std::shared_ptr<dacrt::Device> engine_;  ///< last, because it tells the monitor to its end
};

inline Device& DeviceOf(Device& device) { return device; }

}  // namespace dacrt::compat
