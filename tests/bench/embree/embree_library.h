// One of the two libraries with Embree's interface.
#pragma once

#include <memory>
#include <string>

#include "embree_api.h"
#include "embree_scene.h"

namespace dacrt::bench {

/// A device of a library.
///
/// Devices of Embree that are there at the same time must be for the same number of threads: it
/// gives all of them as many as the largest may have. The number holds for what the other library
/// does with TBB, too, because both use the one TBB of the process.
class EmbreeLibrary {
 public:
  /// `path` contains a slash, and `config` is for rtcNewDevice.
  /// Throws std::runtime_error if the library cannot be had.
  EmbreeLibrary(const std::string& path, const std::string& config);

  const tests::EmbreeApi& api() const { return *api_; }
  const tests::EmbreeDevice& device() const { return *device_; }

 private:
  std::unique_ptr<tests::EmbreeApi> api_;
  std::unique_ptr<tests::EmbreeDevice> device_;
};

/// For rtcNewDevice.
std::string DeviceConfig(const std::string& isa, int threads);

}  // namespace dacrt::bench
