// A device of the drop-in whose memory is counted, and refused where that is wanted.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <string>

#include "embree_scene.h"

namespace dacrt::tests {

class WatchedDevice {
 public:
  /// Throws std::runtime_error if the library refuses `config`.
  explicit WatchedDevice(const std::string& config);

  const EmbreeDevice& device() const { return device_; }

  /// From now on every n-th request is refused; none if n is 0.
  void RefuseEvery(unsigned n) { refuse_every_ = n; }

  /// Bytes that the monitor was told of and that were not given back.
  ssize_t bytes() const { return bytes_; }

 private:
  static bool Monitor(void* self, ssize_t bytes, bool post);

  std::atomic<ssize_t> bytes_{0};
  std::atomic<unsigned> refuse_every_{0}, requests_{0};
  EmbreeDevice device_;  // the last member: its end is watched, too
};

}  // namespace dacrt::tests
