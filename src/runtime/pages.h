// A block of memory straight from the system.
#pragma once

#include <cstddef>
#include <utility>

#include "runtime/memory_account.h"

namespace dacrt {

/// Pages of zeros, which take memory only once they are touched and all go back at the end. Small
/// ones, where there are many, are in large pages (shared_pages.h), which take it as a whole.
class Pages {
 public:
  Pages() = default;
  /// `account`, if there is one, hears of them before and afterwards, and must outlive them. Of the
  /// `span` bytes of addresses, if that is more, no more than `bytes` may be touched.
  /// Throws std::bad_alloc.
  explicit Pages(std::size_t bytes, const MemoryAccount* account = nullptr, std::size_t span = 0)
      : Pages(MemoryClaim(bytes, account), span) {}
  /// The same where the account has heard of them.
  explicit Pages(MemoryClaim&& claim, std::size_t span = 0);
  ~Pages();
  Pages(Pages&& other) noexcept;
  Pages& operator=(Pages&& other) noexcept;

  std::byte* data() const { return data_; }
  std::size_t bytes() const { return claim_.bytes(); }
  std::size_t span() const { return span_; }

  /// From now on no more than this may be touched, which is not more than there are addresses.
  void SetClaim(MemoryClaim&& claim) { claim_ = std::move(claim); }
  /// From now on so much more of the addresses may be touched.
  void Extend(MemoryClaim&& more) { claim_.Join(std::move(more)); }

 private:
  /// Alone, as one of a few small ones, or in large pages.
  enum class Place : unsigned char { kAlone, kOneOfFew, kShared };

  std::byte* data_ = nullptr;
  std::size_t span_ = 0;
  Place place_ = Place::kAlone;
  MemoryClaim claim_;
};

}  // namespace dacrt
