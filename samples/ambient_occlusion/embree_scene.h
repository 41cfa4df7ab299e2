// The device and the scene of Embree, and its errors as exceptions.
#pragma once

#include <Imath/ImathBox.h>
#include <embree3/rtcore.h>

#include <memory>
#include <mutex>
#include <string>

#include "scenes/hall.h"

namespace ao {

class Device {
 public:
  // Throws Error with kEmbree if there can be no such device.
  explicit Device(const std::string& config);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  RTCDevice handle() const { return device_; }

  // Throws the first error that Embree has reported: kMemory if memory ran out, else kEmbree.
  void Check() const;

 private:
  static void OnError(void* self, RTCError code, const char* text);

  RTCDevice device_;
  mutable std::mutex mutex_;  // Embree may report from any of its threads
  RTCError code_ = RTC_ERROR_NONE;
  std::string text_;
};

// One triangle mesh, to be traced.
class Scene {
 public:
  // Takes the mesh over: its memory is free again once Embree has its copy.
  Scene(const Device& device, scenes::Mesh mesh);

  void Commit();
  Imath::Box3f Bounds() const;

  // The closest hit of every ray.
  void Intersect(RTCRayHit* rays, unsigned count, RTCIntersectContextFlags coherence) const;
  // Whether anything is hit: tfar becomes -infinity if so.
  void Occlude(RTCRay* rays, unsigned count) const;

 private:
  struct Release {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };

  const Device& device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
};

}  // namespace ao
