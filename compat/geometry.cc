#include "geometry.h"

#include <algorithm>
#include <new>
#include <utility>

#include "boundary.h"
#include "device.h"
#include "names.h"

namespace dacrt::compat {
namespace {

constexpr std::size_t kVertexBytes = 12;    // FLOAT3
constexpr std::size_t kTriangleBytes = 12;  // UINT3

bool IsAttributeFormat(RTCFormat format) {
  return format >= RTC_FORMAT_FLOAT && format <= RTC_FORMAT_FLOAT16;
}

/// Bytes of one item, of a buffer whose format was checked.
std::size_t ItemBytes(RTCBufferType type, RTCFormat format) {
  switch (type) {
    case RTC_BUFFER_TYPE_INDEX:
      return kTriangleBytes;
    case RTC_BUFFER_TYPE_VERTEX:
      return kVertexBytes;
    default:
      return 4 * static_cast<std::size_t>(format - RTC_FORMAT_FLOAT + 1);
  }
}

/// offset + stride * (count - 1) + last_item_bytes, or nothing for no items. Throws std::bad_alloc
/// beyond the address space.
std::size_t BytesNeeded(std::size_t offset, std::size_t stride, std::size_t count,
                        std::size_t last_item_bytes) {
  if (count == 0) return 0;
  std::size_t bytes;
  if (__builtin_mul_overflow(stride, count - 1, &bytes) ||
      __builtin_add_overflow(bytes, offset, &bytes) ||
      __builtin_add_overflow(bytes, last_item_bytes, &bytes)) {
    throw std::bad_alloc();
  }
  return bytes;
}

[[noreturn]] void FailSlot(RTCError code, RTCBufferType type, unsigned int slot,
                           std::size_t slots) {
  throw ApiError(code, "slot = ", slot, " is not below the number of ", Name(type),
                 " buffers, which is ", slots);
}

[[noreturn]] void FailFormat(RTCBufferType type, RTCFormat format, const char* expected) {
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "format = 0x", std::hex, static_cast<int>(format),
                 ": a triangle mesh's ", Name(type), " buffer has ", expected);
}

[[noreturn]] void FailType(RTCBufferType type) {
  throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "type = ", static_cast<int>(type), " (", Name(type),
                 ") is no buffer of a triangle mesh");
}

}  // namespace

Geometry::Geometry(std::shared_ptr<Device> device, RTCGeometryType type)
    : device_(std::move(device)) {
  if (type == RTC_GEOMETRY_TYPE_TRIANGLE) return;
  const char* const name = Name(type);
  if (!name) {
    throw ApiError(RTC_ERROR_UNKNOWN, "type = ", static_cast<int>(type), " is no geometry type");
  }
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "type = ", static_cast<int>(type), " (", name,
                 ") is not supported yet");
}

Geometry::~Geometry() { HandleTable<Geometry>::Instance().Forget(this); }

void Geometry::Commit() {
  is_modified_ = false;
  ++version_;
}

void Geometry::SetEnabled(bool enabled) {
  if (is_enabled_ == enabled) return;
  is_enabled_ = enabled;
  ++version_;
}

void Geometry::SetMask(uint32_t mask) {
  mask_ = mask;
  is_modified_ = true;
}

void Geometry::SetBuildQuality(RTCBuildQuality quality) {
  // There is nothing to build, so every quality is the same.
  if (quality < RTC_BUILD_QUALITY_LOW || quality > RTC_BUILD_QUALITY_REFIT) {
    throw ApiError(RTC_ERROR_UNKNOWN, "quality = ", static_cast<int>(quality),
                   " is no build quality");
  }
  is_modified_ = true;
}

void Geometry::SetTimeStepCount(unsigned int count) {
  if (count > RTC_MAX_TIME_STEP_COUNT) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "timeStepCount = ", count, " is larger than ",
                   RTC_MAX_TIME_STEP_COUNT);
  }
  if (count > 1) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "timeStepCount = ", count,
                   ": motion blur is not supported yet");
  }
  vertices_.resize(count);
}

void Geometry::SetTimeRange(float start, float end) {
  // With one time step the geometry is there at all times.
  if (start > end) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "startTime = ", start, " is after endTime = ", end);
  }
  is_modified_ = true;
}

void Geometry::SetVertexAttributeCount(unsigned int count) {
  attributes_.resize(count);
  is_modified_ = true;
}

void Geometry::SetBuffer(RTCBufferType type, unsigned int slot, RTCFormat format, BufferView view) {
  CheckBuffer(type, slot, format, view.data(), view.stride, view.count);
  const std::size_t item_bytes = ItemBytes(type, format);
  if (BytesNeeded(view.offset, view.stride, view.count, item_bytes) > view.buffer->bytes()) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "byteOffset = ", view.offset,
                   ", byteStride = ", view.stride, ", itemCount = ", view.count,
                   " reach beyond the buffer's ", view.buffer->bytes(), " bytes");
  }
  View(type, slot) = std::move(view);
}

void Geometry::SetSharedBuffer(RTCBufferType type, unsigned int slot, RTCFormat format, void* data,
                               std::size_t stride, std::size_t count) {
  CheckBuffer(type, slot, format, data, stride, count);
  const std::size_t bytes = BytesNeeded(0, stride, count, ItemBytes(type, format));
  View(type, slot) = {std::make_shared<Buffer>(device_, data, bytes), 0, stride, count};
}

void* Geometry::SetNewBuffer(RTCBufferType type, unsigned int slot, RTCFormat format,
                             std::size_t stride, std::size_t count) {
  CheckBuffer(type, slot, format, nullptr, stride, count);
  // Embree pads these so that a program may read the last item with a 16-byte load.
  const bool is_padded = type != RTC_BUFFER_TYPE_INDEX;
  const std::size_t last_item_bytes =
      std::max(is_padded ? (stride + 15) & ~std::size_t{15} : stride, ItemBytes(type, format));
  const std::size_t bytes = BytesNeeded(0, stride, count, last_item_bytes);
  BufferView& view = View(type, slot);
  view = {std::make_shared<Buffer>(device_, bytes), 0, stride, count};
  return view.data();
}

void* Geometry::BufferData(RTCBufferType type, unsigned int slot) {
  return View(type, slot).data();
}

void Geometry::UpdateBuffer(RTCBufferType type, unsigned int slot) {
  View(type, slot);
  is_modified_ = true;
}

/// The place of the buffer of this type and slot. Throws RTC_ERROR_INVALID_ARGUMENT if there is
/// none.
BufferView& Geometry::View(RTCBufferType type, unsigned int slot) {
  switch (type) {
    case RTC_BUFFER_TYPE_INDEX:
      if (slot != 0) FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, 1);
      return indices_;
    case RTC_BUFFER_TYPE_VERTEX:
      if (slot >= vertices_.size()) {
        FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, vertices_.size());
      }
      return vertices_[slot];
    case RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE:
      if (slot >= attributes_.size()) {
        FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, attributes_.size());
      }
      return attributes_[slot];
    default:
      FailType(type);
  }
}

/// Throws unless memory at `data` can be the buffer of this type and slot. Where several checks
/// fail their order decides the code, and is Embree's; so are the codes, which for a slot differ
/// from View's.
void Geometry::CheckBuffer(RTCBufferType type, unsigned int slot, RTCFormat format,
                           const void* data, std::size_t stride, std::size_t count) const {
  if (count > UINT32_MAX) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "itemCount = ", count, " is larger than 2^32 - 1");
  }
  if (reinterpret_cast<std::uintptr_t>(data) % 4 != 0) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "address ", data, " is no multiple of 4");
  }
  if (stride % 4 != 0) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "byteStride = ", stride, " is no multiple of 4");
  }
  switch (type) {
    case RTC_BUFFER_TYPE_INDEX:
      if (slot != 0) FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, 1);
      if (format != RTC_FORMAT_UINT3) FailFormat(type, format, "UINT3");
      return;
    case RTC_BUFFER_TYPE_VERTEX:
      if (format != RTC_FORMAT_FLOAT3) FailFormat(type, format, "FLOAT3");
      if (slot >= vertices_.size()) {
        FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, vertices_.size());
      }
      return;
    case RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE:
      if (!IsAttributeFormat(format)) FailFormat(type, format, "FLOAT to FLOAT16");
      if (slot >= attributes_.size()) {
        FailSlot(RTC_ERROR_INVALID_OPERATION, type, slot, attributes_.size());
      }
      return;
    default:
      FailType(type);
  }
}

dacrt::TriangleMesh Geometry::Mesh(uint32_t geometry_id) const {
  dacrt::TriangleMesh mesh;
  mesh.geometry_id = geometry_id;
  mesh.mask = device_->ignore_masks() ? UINT32_MAX : mask_;
  if (vertices_.empty() || !vertices_[0].data() || !indices_.data()) return mesh;
  mesh.vertices = vertices_[0].data();
  mesh.vertex_stride = vertices_[0].stride;
  mesh.vertex_count = vertices_[0].count;
  mesh.triangles = indices_.data();
  mesh.triangle_stride = indices_.stride;
  mesh.triangle_count = indices_.count;
  return mesh;
}

std::vector<std::shared_ptr<const Buffer>> Geometry::MeshBuffers() const {
  std::vector<std::shared_ptr<const Buffer>> buffers{indices_.buffer};
  for (const BufferView& view : vertices_) buffers.push_back(view.buffer);
  return buffers;
}

}  // namespace dacrt::compat
