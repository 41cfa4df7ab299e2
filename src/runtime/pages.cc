#include "runtime/pages.h"

#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <utility>

#include "runtime/shared_pages.h"

namespace dacrt {
namespace {

/// Small ones that stand alone, and how many of them suffice: programs with no more have no use for
/// a large page.
std::atomic<std::size_t> few{0};
constexpr std::size_t kFew = 16;

std::byte* Map(std::size_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  // Large pages make the first touch, and every later one, cheaper. Without them all still works.
  madvise(memory, bytes, MADV_HUGEPAGE);
  return static_cast<std::byte*>(memory);
}

}  // namespace

Pages::Pages(MemoryClaim&& claim, std::size_t span)
    : span_(std::max(claim.bytes(), span)), claim_(std::move(claim)) {
  if (span_ == 0) return;
  // What may not be touched is not for large pages.
  const bool is_small = span_ == bytes() && span_ <= SharedPages::kMostBytes;
  if (is_small && few >= kFew) data_ = SharedPages::Get().Take(span_);
  if (data_) {
    place_ = Place::kShared;
    return;
  }
  data_ = Map(span_);
  if (!is_small) return;
  place_ = Place::kOneOfFew;
  ++few;
}

// The pages go before the account hears of it.
Pages::~Pages() {
  if (place_ == Place::kShared) {
    SharedPages::Get().Return(data_, span_);
  } else if (data_) {
    munmap(data_, span_);
    if (place_ == Place::kOneOfFew) --few;
  }
}

Pages::Pages(Pages&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      span_(std::exchange(other.span_, 0)),
      place_(std::exchange(other.place_, Place::kAlone)),
      claim_(std::move(other.claim_)) {}

Pages& Pages::operator=(Pages&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(span_, other.span_);
  std::swap(place_, other.place_);
  claim_ = std::move(other.claim_);
  return *this;
}

}  // namespace dacrt
