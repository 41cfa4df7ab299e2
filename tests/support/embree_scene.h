// Devices and scenes of either library, released when they go out of scope.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "embree_api.h"
#include "scenes.h"

namespace dacrt::tests {

class EmbreeDevice {
 public:
  /// Throws std::runtime_error if the library refuses `config`.
  EmbreeDevice(const EmbreeApi& api, const std::string& config);
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  const EmbreeApi& api() const { return api_; }
  RTCDevice handle() const { return handle_; }

  /// Throws std::runtime_error if a call since the last check has failed.
  void CheckErrors() const;

 private:
  const EmbreeApi& api_;
  RTCDevice handle_;
};

/// A test scene as one library holds it, committed.
class EmbreeScene {
 public:
  /// Throws std::runtime_error if the library reports an error.
  EmbreeScene(const EmbreeDevice& device, const TestScene& scene,
              RTCSceneFlags flags = RTC_SCENE_FLAG_NONE);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  const EmbreeApi& api() const { return device_.api(); }
  RTCScene handle() const { return handle_; }
  RTCBounds Bounds() const;

 private:
  void Attach(const TestMesh& mesh);

  const EmbreeDevice& device_;
  RTCScene handle_;
  std::vector<std::vector<std::byte>> buffers_;  ///< what the library shares
};

}  // namespace dacrt::tests
