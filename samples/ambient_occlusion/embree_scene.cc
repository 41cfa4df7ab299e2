#include "ambient_occlusion/embree_scene.h"

#include <algorithm>

#include "ambient_occlusion/error.h"

namespace ao {
namespace {

void ThrowError(RTCError code, const std::string& text) {
  if (code == RTC_ERROR_OUT_OF_MEMORY) throw Error(ExitCode::kMemory, "out of memory");
  throw Error(ExitCode::kEmbree, "Embree reports error " + std::to_string(code) +
                                     (text.empty() ? std::string() : ": " + text));
}

}  // namespace

Device::Device(const std::string& config) : device_(rtcNewDevice(config.c_str())) {
  if (!device_) ThrowError(rtcGetDeviceError(nullptr), "there is no device '" + config + "'");
  rtcSetDeviceErrorFunction(device_, &Device::OnError, this);
}

Device::~Device() { rtcReleaseDevice(device_); }

void Device::Check() const {
  const std::lock_guard lock(mutex_);
  if (code_ != RTC_ERROR_NONE) ThrowError(code_, text_);
}

void Device::OnError(void* self, RTCError code, const char* text) {
  Device& device = *static_cast<Device*>(self);
  const std::lock_guard lock(device.mutex_);
  if (device.code_ != RTC_ERROR_NONE) return;  // what follows the first error is its echo
  device.code_ = code;
  device.text_ = text ? text : "";
}

Scene::Scene(const Device& device, scenes::Mesh mesh)
    : device_(device), scene_(rtcNewScene(device.handle())) {
  RTCGeometry geometry = rtcNewGeometry(device.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            3 * sizeof(float), mesh.VertexCount());
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(uint32_t), mesh.TriangleCount());
  if (positions && indices) {
    std::copy(mesh.positions.begin(), mesh.positions.end(), static_cast<float*>(positions));
    std::copy(mesh.indices.begin(), mesh.indices.end(), static_cast<uint32_t*>(indices));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_.get(), geometry);
  }
  rtcReleaseGeometry(geometry);
  device_.Check();
}

void Scene::Commit() {
  rtcCommitScene(scene_.get());
  device_.Check();
}

Imath::Box3f Scene::Bounds() const {
  RTCBounds bounds;
  rtcGetSceneBounds(scene_.get(), &bounds);
  device_.Check();
  return {{bounds.lower_x, bounds.lower_y, bounds.lower_z},
          {bounds.upper_x, bounds.upper_y, bounds.upper_z}};
}

void Scene::Intersect(RTCRayHit* rays, unsigned count, RTCIntersectContextFlags coherence) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherence;
  rtcIntersect1M(scene_.get(), &context, rays, count, sizeof(RTCRayHit));
  device_.Check();
}

void Scene::Occlude(RTCRay* rays, unsigned count) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  rtcOccluded1M(scene_.get(), &context, rays, count, sizeof(RTCRay));
  device_.Check();
}

}  // namespace ao
