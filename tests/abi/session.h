// A device of one library with its errors, and the objects of a small scene on it.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "api.h"

namespace dacrt::tests {

/// One call of a device's error function.
struct ErrorReport {
  RTCError code;
  std::string message;
};

/// Handles that its functions return are released when it ends; Own() adds others.
class Session {
 public:
  explicit Session(const Api& api, const char* config = nullptr);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const Api& api;
  const RTCDevice device;

  /// What the error function was told, in order.
  std::vector<ErrorReport> reports;

  RTCDevice Own(RTCDevice owned);
  RTCBuffer Own(RTCBuffer owned);
  RTCGeometry Own(RTCGeometry owned);
  RTCScene Own(RTCScene owned);

  RTCDevice OtherDevice() { return Own(api.rtcNewDevice(nullptr)); }
  RTCBuffer NewBuffer(std::size_t bytes) { return Own(api.rtcNewBuffer(device, bytes)); }
  RTCGeometry NewGeometry() { return Own(api.rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE)); }
  RTCScene NewScene() { return Own(api.rtcNewScene(device)); }

  /// The triangle (0, 0, z), (1, 0, z), (0, 1, z) in shared buffers, not committed.
  RTCGeometry UncommittedTriangle(float z = 0);
  RTCGeometry Triangle(float z = 0);

  /// A committed scene of one geometry.
  RTCScene SceneOf(RTCGeometry geometry);

  /// The device's error of this thread, which is none afterwards.
  RTCError TakeError() { return api.rtcGetDeviceError(device); }

  /// The geometry that the ray from (0.2, 0.2, -10) along +z with this mask hits; the invalid ID
  /// for a miss.
  unsigned int HitGeometry(RTCScene scene, unsigned int mask = 0xFFFFFFFF);
  /// The tfar that this ray has then, as WholeDistance gives it.
  float Distance(RTCScene scene);
  /// Commits a scene, and expects that, and no error.
  void ExpectAtCommit(RTCScene scene, float distance, const char* when);

  /// From now on the device gets no memory.
  void RefuseMemory();
  void GrantMemory() { api.rtcSetDeviceMemoryMonitorFunction(device, nullptr, nullptr); }

  struct Mesh {
    float vertices[3][4];
    unsigned int indices[3];
  };

 private:
  std::vector<std::function<void()>> releases_;
  std::vector<std::unique_ptr<Mesh>> meshes_;
};

/// The record of the ray from (x, 0.2, -10) along +z, with an invalid hit.
RTCRayHit RayAt(float x, unsigned int mask = 0xFFFFFFFF);

/// `distance`, which in exact arithmetic is a whole number, as it is compared with that. The real
/// library multiplies by an approximate reciprocal, and on some processors 1 comes out as
/// 0.99999994: of its distances the whole number is taken that is not more than 2 units in the last
/// place away. The drop-in's are as they are.
float WholeDistance(const Api& api, float distance);

/// Packets of 16 that the library traces as such. Without AVX-512 the real one makes streams of
/// them and passes over which of their rays are valid.
bool HasPacketsOf16(const Session& s);

/// Runs a test's body on either library: `GetParam()()` is the library.
class OnBothLibraries : public testing::TestWithParam<const Api& (*)()> {};

#define INSTANTIATE_ON_BOTH_LIBRARIES(suite)                               \
  INSTANTIATE_TEST_SUITE_P(, suite, testing::Values(&RealEmbree, &DropIn), \
                           [](const auto& info) { return std::string(info.param().name); })

}  // namespace dacrt::tests
