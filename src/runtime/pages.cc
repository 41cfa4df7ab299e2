#include "runtime/pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <new>
#include <utility>

namespace dacrt {

Pages::Pages(std::size_t bytes, const MemoryAccount* account, std::size_t span)
    : span_(std::max(bytes, span)), claim_(bytes, account) {
  if (span_ == 0) return;
  void* memory = mmap(nullptr, span_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  // Large pages make the first touch, and every later one, cheaper. Without them all still works.
  madvise(memory, span_, MADV_HUGEPAGE);
  data_ = static_cast<std::byte*>(memory);
}

// The pages go before the account hears of it.
Pages::~Pages() {
  if (data_) munmap(data_, span_);
}

Pages::Pages(Pages&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      span_(std::exchange(other.span_, 0)),
      claim_(std::move(other.claim_)) {}

Pages& Pages::operator=(Pages&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(span_, other.span_);
  claim_ = std::move(other.claim_);
  return *this;
}

}  // namespace dacrt
