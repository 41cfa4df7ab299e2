// Memory that geometries read: the program's own, or allocated here.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>
#include <cstdint>
#include <memory>

#include "handles.h"

namespace dacrt::compat {

class Buffer : public std::enable_shared_from_this<Buffer> {
 public:
  /// Allocates `bytes`, aligned to 64. The contents are undefined; data() is null for no bytes.
  Buffer(std::shared_ptr<Device> device, std::size_t bytes);

  /// Refers to the program's memory at `data`, which must not be null and must outlive every use.
  Buffer(std::shared_ptr<Device> device, void* data, std::size_t bytes);

  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  std::byte* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }
  Device& device() const { return *device_; }

 private:
  const std::shared_ptr<Device> device_;
  const std::size_t bytes_;
  const bool owned_;
  std::byte* data_;
};

/// A new buffer: the program's memory at `data`, or for a null pointer memory of its own, which is
/// what Embree does.
std::shared_ptr<Buffer> MakeBuffer(std::shared_ptr<Device> device, void* data, std::size_t bytes);

/// Part of a buffer, as a geometry uses it. Empty while `buffer` is null.
struct BufferView {
  std::shared_ptr<Buffer> buffer;
  std::size_t offset = 0;
  std::size_t stride = 0;
  std::size_t count = 0;
  RTCFormat format = RTC_FORMAT_UNDEFINED;

  /// Where item 0 stands; null if there is no memory. As a number: before it is checked the offset
  /// may lead out of the address space.
  std::byte* data() const {
    if (!buffer || !buffer->data()) return nullptr;
    return reinterpret_cast<std::byte*>(reinterpret_cast<std::uintptr_t>(buffer->data()) + offset);
  }
};

inline Device& DeviceOf(Buffer& buffer) { return buffer.device(); }

}  // namespace dacrt::compat
