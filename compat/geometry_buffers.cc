#include "geometry_buffers.h"

#include <algorithm>
#include <new>
#include <utility>

#include "boundary.h"
#include "names.h"

namespace dacrt::compat {
namespace {

bool IsPoint(RTCGeometryType type) {
  return type == RTC_GEOMETRY_TYPE_SPHERE_POINT || type == RTC_GEOMETRY_TYPE_DISC_POINT ||
         type == RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT;
}

bool IsAttributeFormat(RTCFormat format) {
  return format >= RTC_FORMAT_FLOAT && format <= RTC_FORMAT_FLOAT16;
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

/// The formats of the buffers that have one.
RTCFormat FormatOf(RTCGeometryType geometry, RTCBufferType type) {
  switch (type) {
    case RTC_BUFFER_TYPE_INDEX:
      return geometry == RTC_GEOMETRY_TYPE_QUAD ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3;
    case RTC_BUFFER_TYPE_GRID:
      return RTC_FORMAT_GRID;
    case RTC_BUFFER_TYPE_VERTEX:
      return IsPoint(geometry) ? RTC_FORMAT_FLOAT4 : RTC_FORMAT_FLOAT3;
    default:
      return RTC_FORMAT_FLOAT3;  // normals
  }
}

const char* NameOf(RTCFormat format) {
  switch (format) {
    case RTC_FORMAT_UINT3:
      return "UINT3";
    case RTC_FORMAT_UINT4:
      return "UINT4";
    case RTC_FORMAT_GRID:
      return "GRID";
    case RTC_FORMAT_FLOAT4:
      return "FLOAT4";
    default:
      return "FLOAT3";
  }
}

}  // namespace

GeometryBuffers::GeometryBuffers(std::shared_ptr<Device> device, RTCGeometryType type)
    : device_(std::move(device)), geometry_type_(type) {}

bool GeometryBuffers::Has(RTCBufferType type) const {
  switch (type) {
    case RTC_BUFFER_TYPE_VERTEX:
    case RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE:
      return true;
    case RTC_BUFFER_TYPE_INDEX:
      return geometry_type_ == RTC_GEOMETRY_TYPE_TRIANGLE ||
             geometry_type_ == RTC_GEOMETRY_TYPE_QUAD;
    case RTC_BUFFER_TYPE_GRID:
      return geometry_type_ == RTC_GEOMETRY_TYPE_GRID;
    case RTC_BUFFER_TYPE_NORMAL:
      return geometry_type_ == RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT;
    default:
      return false;
  }
}

std::size_t GeometryBuffers::ItemBytes(RTCBufferType type, RTCFormat format) const {
  if (type == RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE) {
    return 4 * static_cast<std::size_t>(format - RTC_FORMAT_FLOAT + 1);
  }
  switch (format) {
    case RTC_FORMAT_UINT4:
    case RTC_FORMAT_FLOAT4:
      return 16;
    default:
      return 12;  // three values, or a grid
  }
}

void GeometryBuffers::Set(RTCBufferType type, unsigned int slot, RTCFormat format,
                          BufferView view) {
  Check(type, slot, format, view.data(), view.stride, view.count);
  const std::size_t item_bytes = ItemBytes(type, format);
  if (BytesNeeded(view.offset, view.stride, view.count, item_bytes) > view.buffer->bytes()) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "byteOffset = ", view.offset,
                   ", byteStride = ", view.stride, ", itemCount = ", view.count,
                   " reach beyond the buffer's ", view.buffer->bytes(), " bytes");
  }
  view.format = format;
  Place(type, slot) = std::move(view);
}

void GeometryBuffers::SetShared(RTCBufferType type, unsigned int slot, RTCFormat format, void* data,
                                std::size_t stride, std::size_t count) {
  Check(type, slot, format, data, stride, count);
  const std::size_t bytes = BytesNeeded(0, stride, count, ItemBytes(type, format));
  Place(type, slot) = {std::make_shared<Buffer>(device_, data, bytes), 0, stride, count, format};
}

void* GeometryBuffers::SetNew(RTCBufferType type, unsigned int slot, RTCFormat format,
                              std::size_t stride, std::size_t count) {
  Check(type, slot, format, nullptr, stride, count);
  // Embree pads these so that a program may read the last item with a 16-byte load.
  const bool is_padded = type != RTC_BUFFER_TYPE_INDEX && type != RTC_BUFFER_TYPE_GRID;
  const std::size_t last_item_bytes =
      std::max(is_padded ? (stride + 15) & ~std::size_t{15} : stride, ItemBytes(type, format));
  const std::size_t bytes = BytesNeeded(0, stride, count, last_item_bytes);
  BufferView& view = Place(type, slot);
  view = {std::make_shared<Buffer>(device_, bytes), 0, stride, count, format};
  return view.data();
}

/// The place of the buffer of this type and slot.
BufferView& GeometryBuffers::Place(RTCBufferType type, unsigned int slot) {
  return const_cast<BufferView&>(View(type, slot));
}

const BufferView& GeometryBuffers::View(RTCBufferType type, unsigned int slot) const {
  CheckHasAny();
  if (!Has(type)) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "type = ", static_cast<int>(type), " (", Name(type),
                   ") is no buffer of a ", Name(geometry_type_));
  }
  const auto in = [&](const std::vector<BufferView>& views) -> const BufferView& {
    if (slot >= views.size()) FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, views.size());
    return views[slot];
  };
  switch (type) {
    case RTC_BUFFER_TYPE_VERTEX:
      return in(vertices_);
    case RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE:
      return in(attributes_);
    case RTC_BUFFER_TYPE_NORMAL:
      return in(normals_);
    default:
      if (slot != 0) FailSlot(RTC_ERROR_INVALID_ARGUMENT, type, slot, 1);
      return primitives_;
  }
}

void GeometryBuffers::CheckHasAny() const {
  if (geometry_type_ != RTC_GEOMETRY_TYPE_USER && geometry_type_ != RTC_GEOMETRY_TYPE_INSTANCE) {
    return;
  }
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry is a ", Name(geometry_type_),
                 ", which has no buffers");
}

void GeometryBuffers::CheckFormat(RTCBufferType type, RTCFormat format) const {
  if (type == RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE ? IsAttributeFormat(format)
                                               : format == FormatOf(geometry_type_, type)) {
    return;
  }
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "format = 0x", std::hex, static_cast<int>(format),
                 ": the ", Name(type), " buffer of a ", Name(geometry_type_), " has ",
                 type == RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE ? "FLOAT to FLOAT16"
                                                          : NameOf(FormatOf(geometry_type_, type)));
}

/// Throws unless memory at `data` can be the buffer of this type and slot. Where several checks
/// fail their order decides the code, and is Embree's; so are the codes, which for a slot differ
/// from View's.
void GeometryBuffers::Check(RTCBufferType type, unsigned int slot, RTCFormat format,
                            const void* data, std::size_t stride, std::size_t count) const {
  if (count > UINT32_MAX) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "itemCount = ", count, " is larger than 2^32 - 1");
  }
  CheckHasAny();
  // Flags, which belong to curves, are bytes.
  const bool is_of_words = !(IsPoint(geometry_type_) && type == RTC_BUFFER_TYPE_FLAGS);
  if (is_of_words && reinterpret_cast<std::uintptr_t>(data) % 4 != 0) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "address ", data, " is no multiple of 4");
  }
  if (is_of_words && stride % 4 != 0) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "byteStride = ", stride, " is no multiple of 4");
  }
  if (!Has(type)) {
    // Embree's quads take every type behind attributes for attributes, and accept some.
    const bool is_quad =
        geometry_type_ == RTC_GEOMETRY_TYPE_QUAD && type > RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE;
    throw ApiError(is_quad ? RTC_ERROR_INVALID_OPERATION : RTC_ERROR_INVALID_ARGUMENT,
                   "type = ", static_cast<int>(type), " (", Name(type), ") is no buffer of a ",
                   Name(geometry_type_));
  }
  const auto check_slot = [&](RTCError code, std::size_t slots) {
    if (slot >= slots) FailSlot(code, type, slot, slots);
  };
  switch (type) {
    case RTC_BUFFER_TYPE_VERTEX:
      CheckFormat(type, format);
      return check_slot(RTC_ERROR_INVALID_ARGUMENT, vertices_.size());
    case RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE:
      CheckFormat(type, format);
      return check_slot(RTC_ERROR_INVALID_OPERATION, attributes_.size());
    case RTC_BUFFER_TYPE_NORMAL:
      CheckFormat(type, format);
      return check_slot(RTC_ERROR_INVALID_OPERATION, normals_.size());
    default:
      check_slot(RTC_ERROR_INVALID_ARGUMENT, 1);
      return CheckFormat(type, format);
  }
}

std::size_t GeometryBuffers::PrimitiveCount() const {
  if (!IsPoint(geometry_type_)) return primitives_.count;
  return vertices_.empty() ? 0 : vertices_[0].count;
}

void GeometryBuffers::SetTimeStepCount(unsigned int count) {
  vertices_.resize(count);
  normals_.resize(count);
}

void GeometryBuffers::SetVertexAttributeCount(unsigned int count) {
  CheckHasAny();
  attributes_.resize(count);
}

void GeometryBuffers::CheckForCommit() const {
  const auto check_strides = [](const std::vector<BufferView>& views, RTCBufferType type) {
    for (std::size_t step = 1; step < views.size(); ++step) {
      // One that was not set has a stride of 0.
      if (views[step].stride == views[0].stride) continue;
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "the ", Name(type), " buffer in slot ", step,
                     " has byteStride = ", views[step].stride, ", the one in slot 0 has ",
                     views[0].stride);
    }
  };
  check_strides(vertices_, RTC_BUFFER_TYPE_VERTEX);
  if (!Has(RTC_BUFFER_TYPE_NORMAL)) return;
  check_strides(normals_, RTC_BUFFER_TYPE_NORMAL);
  // Embree reads what is not there.
  for (std::size_t step = 0; step < normals_.size(); ++step) {
    if (normals_[step].count >= vertices_[0].count) continue;
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "the NORMAL buffer in slot ", step, " has ",
                   normals_[step].count, " items for ", vertices_[0].count, " vertices");
  }
}

void GeometryBuffers::Describe(dacrt::Geometry& geometry) const {
  const bool has_normals = Has(RTC_BUFFER_TYPE_NORMAL);
  const auto is_set = [](const BufferView& view) { return view.data() != nullptr; };
  const bool is_complete =
      !vertices_.empty() && std::all_of(vertices_.begin(), vertices_.end(), is_set) &&
      (!has_normals || std::all_of(normals_.begin(), normals_.end(), is_set)) &&
      (IsPoint(geometry_type_) || primitives_.data());
  if (!is_complete) {
    geometry.vertices.resize(1);
    geometry.normals.resize(has_normals);
    return;
  }
  const auto array = [](const BufferView& view) { return Array{view.data(), view.stride}; };
  geometry.vertex_count = vertices_[0].count;
  for (const BufferView& view : vertices_) {
    geometry.vertices.push_back(array(view));
    geometry.vertex_count = std::min(geometry.vertex_count, view.count);
  }
  if (has_normals) {
    for (const BufferView& view : normals_) {
      geometry.normals.push_back(array(view));
      geometry.vertex_count = std::min(geometry.vertex_count, view.count);
    }
  }
  geometry.primitives = array(primitives_);
  geometry.primitive_count = IsPoint(geometry_type_) ? geometry.vertex_count : primitives_.count;
}

void GeometryBuffers::AddUsed(std::vector<std::shared_ptr<const void>>& used) const {
  const auto add = [&](const BufferView& view) {
    if (view.buffer) used.push_back(view.buffer);
  };
  add(primitives_);
  for (const auto* views : {&vertices_, &normals_}) {
    for (const BufferView& view : *views) add(view);
  }
}

}  // namespace dacrt::compat
