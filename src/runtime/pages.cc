#include "runtime/pages.h"

#include <sys/mman.h>

#include <new>
#include <utility>

namespace dacrt {

Pages::Pages(std::size_t bytes, const MemoryAccount* account) : account_(account) {
  if (bytes == 0) return;
  if (account) account->Take(bytes);
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    if (account) account->Give(bytes);
    throw std::bad_alloc();
  }
  // Large pages make the first touch, and every later one, cheaper. Without them all still works.
  madvise(memory, bytes, MADV_HUGEPAGE);
  data_ = static_cast<std::byte*>(memory);
  bytes_ = bytes;
}

Pages::~Pages() {
  if (!data_) return;
  munmap(data_, bytes_);
  if (account_) account_->Give(bytes_);
}

Pages::Pages(Pages&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      bytes_(std::exchange(other.bytes_, 0)),
      account_(other.account_) {}

Pages& Pages::operator=(Pages&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(bytes_, other.bytes_);
  std::swap(account_, other.account_);
  return *this;
}

}  // namespace dacrt
