// A block of memory straight from the system.
#pragma once

#include <cstddef>

#include "runtime/memory_account.h"

namespace dacrt {

/// Pages of zeros, which take memory only once they are touched and all go back at the end.
class Pages {
 public:
  Pages() = default;
  /// `account`, if there is one, hears of them before and afterwards, and must outlive them.
  /// Throws std::bad_alloc.
  explicit Pages(std::size_t bytes, const MemoryAccount* account = nullptr);
  ~Pages();
  Pages(Pages&& other) noexcept;
  Pages& operator=(Pages&& other) noexcept;

  std::byte* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }

 private:
  std::byte* data_ = nullptr;
  std::size_t bytes_ = 0;
  const MemoryAccount* account_ = nullptr;
};

}  // namespace dacrt
