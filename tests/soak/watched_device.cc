#include "watched_device.h"

#include "contest.h"

namespace dacrt::tests {

WatchedDevice::WatchedDevice(const std::string& config) : device_(DropIn(), config) {
  DropIn().rtcSetDeviceMemoryMonitorFunction(device_.handle(), &Monitor, this);
}

bool WatchedDevice::Monitor(void* self, ssize_t bytes, bool post) {
  auto& device = *static_cast<WatchedDevice*>(self);
  const unsigned every = device.refuse_every_;
  if (bytes > 0 && !post && every != 0 && ++device.requests_ % every == 0) {
    // What is refused has been counted by nobody, and nobody gives it back.
    return false;
  }
  device.bytes_ += bytes;
  return true;
}

}  // namespace dacrt::tests
