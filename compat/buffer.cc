#include "buffer.h"

#include <cstdlib>
#include <new>
#include <utility>

#include "device.h"

namespace dacrt::compat {
namespace {

/// Embree's alignment, which is a cache line and the widest vector.
constexpr std::size_t kAlignment = 64;

std::byte* Allocate(Device& device, std::size_t bytes) {
  if (bytes == 0) return nullptr;
  device.AnnounceAllocation(bytes);
  const std::size_t rounded = (bytes + kAlignment - 1) / kAlignment * kAlignment;  // 0: overflow
  void* const data = rounded == 0 ? nullptr : std::aligned_alloc(kAlignment, rounded);
  if (!data) {
    device.AnnounceFree(bytes);
    throw std::bad_alloc();
  }
  return static_cast<std::byte*>(data);
}

}  // namespace

Buffer::Buffer(std::shared_ptr<Device> device, std::size_t bytes)
    : device_(std::move(device)), bytes_(bytes), owned_(true), data_(Allocate(*device_, bytes)) {}

Buffer::Buffer(std::shared_ptr<Device> device, void* data, std::size_t bytes)
    : device_(std::move(device)),
      bytes_(bytes),
      owned_(false),
      data_(static_cast<std::byte*>(data)) {}

Buffer::~Buffer() {
  HandleTable<Buffer>::Instance().Forget(this);
  if (owned_ && data_) {
    std::free(data_);
    device_->AnnounceFree(bytes_);
  }
}

std::shared_ptr<Buffer> MakeBuffer(std::shared_ptr<Device> device, void* data, std::size_t bytes) {
  if (data) return std::make_shared<Buffer>(std::move(device), data, bytes);
  return std::make_shared<Buffer>(std::move(device), bytes);
}

}  // namespace dacrt::compat
