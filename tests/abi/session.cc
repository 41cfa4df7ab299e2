#include "session.h"

#include <sys/types.h>

#include <cmath>

namespace dacrt::tests {
namespace {

void KeepReport(void* reports, RTCError code, const char* message) {
  static_cast<std::vector<ErrorReport>*>(reports)->push_back({code, message});
}

}  // namespace

Session::Session(const Api& session_api, const char* config)
    : api(session_api), device(api.rtcNewDevice(config)) {
  api.rtcSetDeviceErrorFunction(device, KeepReport, &reports);
}

Session::~Session() {
  // In reverse: what was made last goes first.
  for (auto release = releases_.rbegin(); release != releases_.rend(); ++release) (*release)();
  api.rtcReleaseDevice(device);
}

RTCDevice Session::Own(RTCDevice owned) {
  if (owned) releases_.push_back([this, owned] { api.rtcReleaseDevice(owned); });
  return owned;
}

RTCBuffer Session::Own(RTCBuffer owned) {
  if (owned) releases_.push_back([this, owned] { api.rtcReleaseBuffer(owned); });
  return owned;
}

RTCGeometry Session::Own(RTCGeometry owned) {
  if (owned) releases_.push_back([this, owned] { api.rtcReleaseGeometry(owned); });
  return owned;
}

RTCScene Session::Own(RTCScene owned) {
  if (owned) releases_.push_back([this, owned] { api.rtcReleaseScene(owned); });
  return owned;
}

RTCGeometry Session::UncommittedTriangle(float z) {
  meshes_.push_back(
      std::make_unique<Mesh>(Mesh{{{0, 0, z, 0}, {1, 0, z, 0}, {0, 1, z, 0}}, {0, 1, 2}}));
  const Mesh& mesh = *meshes_.back();
  const RTCGeometry geometry = NewGeometry();
  api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                 mesh.vertices, 0, 16, 3);
  api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.indices,
                                 0, 12, 1);
  return geometry;
}

RTCGeometry Session::Triangle(float z) {
  const RTCGeometry geometry = UncommittedTriangle(z);
  api.rtcCommitGeometry(geometry);
  return geometry;
}

RTCScene Session::SceneOf(RTCGeometry geometry) {
  const RTCScene scene = NewScene();
  api.rtcAttachGeometry(scene, geometry);
  api.rtcCommitScene(scene);
  return scene;
}

unsigned int Session::HitGeometry(RTCScene scene, unsigned int mask) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = RayAt(0.2f, mask);
  api.rtcIntersect1M(scene, &context, &ray, 1, sizeof ray);
  return ray.hit.geomID;
}

float Session::Distance(RTCScene scene) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray = RayAt(0.2f);
  api.rtcIntersect1(scene, &context, &ray);
  return WholeDistance(api, ray.ray.tfar);
}

void Session::ExpectAtCommit(RTCScene scene, float distance, const char* when) {
  api.rtcCommitScene(scene);
  EXPECT_EQ(Distance(scene), distance) << when;
  EXPECT_EQ(TakeError(), RTC_ERROR_NONE) << when;
}

void Session::RefuseMemory() {
  api.rtcSetDeviceMemoryMonitorFunction(
      device, [](void*, ssize_t bytes, bool) { return bytes <= 0; }, nullptr);
}

RTCRayHit RayAt(float x, unsigned int mask) {
  RTCRayHit record{};
  record.ray.org_x = x;
  record.ray.org_y = 0.2f;
  record.ray.org_z = -10;
  record.ray.dir_z = 1;
  record.ray.tfar = 1000;
  record.ray.mask = mask;
  record.hit.primID = record.hit.geomID = record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return record;
}

float WholeDistance(const Api& api, float distance) {
  const float whole = std::round(distance);
  const float unit = std::nextafter(whole, INFINITY) - whole;
  return &api == &RealEmbree() && std::abs(distance - whole) <= 2 * unit ? whole : distance;
}

bool HasPacketsOf16(const Session& s) {
  return s.api.rtcGetDeviceProperty(s.device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) == 1;
}

}  // namespace dacrt::tests
