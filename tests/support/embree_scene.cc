#include "embree_scene.h"

#include <cstring>
#include <span>
#include <stdexcept>

namespace dacrt::tests {
namespace {

/// What lies between the items of a buffer, which no library may take for data.
constexpr std::byte kGap{0xff};

/// Embree loads sixteen bytes at each vertex, also at the last one.
constexpr std::size_t kBufferTail = 16;

template <typename Item>
std::vector<std::byte> MakeBuffer(std::span<const Item> items, std::size_t offset,
                                  std::size_t stride) {
  std::vector<std::byte> buffer(offset + items.size() * stride + kBufferTail, kGap);
  for (std::size_t i = 0; i < items.size(); ++i) {
    std::memcpy(buffer.data() + offset + i * stride, &items[i], sizeof(Item));
  }
  return buffer;
}

}  // namespace

EmbreeDevice::EmbreeDevice(const EmbreeApi& api, const std::string& config)
    : api_(api), handle_(api.rtcNewDevice(config.c_str())) {
  if (!handle_) {
    throw std::runtime_error(api.path + " refuses the configuration '" + config + "', error " +
                             std::to_string(api.rtcGetDeviceError(nullptr)));
  }
  try {
    CheckErrors();
  } catch (...) {
    api.rtcReleaseDevice(handle_);
    throw;
  }
}

EmbreeDevice::~EmbreeDevice() { api_.rtcReleaseDevice(handle_); }

void EmbreeDevice::CheckErrors() const {
  const RTCError error = api_.rtcGetDeviceError(handle_);
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error(api_.path + " reports error " + std::to_string(error));
  }
}

EmbreeScene::EmbreeScene(const EmbreeDevice& device, const TestScene& scene, RTCSceneFlags flags)
    : device_(device), handle_(device.api().rtcNewScene(device.handle())) {
  try {
    api().rtcSetSceneFlags(handle_, flags);
    for (const TestMesh& mesh : scene.meshes) Attach(mesh);
    api().rtcCommitScene(handle_);
    device_.CheckErrors();
  } catch (...) {
    api().rtcReleaseScene(handle_);
    throw;
  }
}

EmbreeScene::~EmbreeScene() { api().rtcReleaseScene(handle_); }

RTCBounds EmbreeScene::Bounds() const {
  RTCBounds bounds;
  api().rtcGetSceneBounds(handle_, &bounds);
  return bounds;
}

void EmbreeScene::Attach(const TestMesh& mesh) {
  const BufferLayout& layout = mesh.layout;
  const RTCGeometry geometry = api().rtcNewGeometry(device_.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  buffers_.push_back(MakeBuffer(std::span<const Float3>(mesh.positions), layout.vertex_offset,
                                layout.vertex_stride));
  api().rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   buffers_.back().data(), layout.vertex_offset,
                                   layout.vertex_stride, mesh.positions.size());
  buffers_.push_back(MakeBuffer(std::span<const Triangle>(mesh.triangles), layout.index_offset,
                                layout.index_stride));
  api().rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   buffers_.back().data(), layout.index_offset, layout.index_stride,
                                   mesh.triangles.size());
  api().rtcSetGeometryMask(geometry, mesh.mask);
  api().rtcCommitGeometry(geometry);
  api().rtcAttachGeometryByID(handle_, geometry, mesh.geometry_id);
  if (!mesh.enabled) api().rtcDisableGeometry(geometry);
  api().rtcReleaseGeometry(geometry);
  device_.CheckErrors();
}

}  // namespace dacrt::tests
