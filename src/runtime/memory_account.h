// What a device tells its memory monitor.
#pragma once

#include <cstddef>
#include <new>
#include <utility>

#include "dacrt/dacrt.h"

namespace dacrt {

class MemoryAccount {
 public:
  explicit MemoryAccount(MemoryMonitor monitor) : monitor_(std::move(monitor)) {}

  /// Before memory is taken. Throws std::bad_alloc if the monitor refuses.
  void Take(std::size_t bytes) const {
    if (bytes == 0 || !monitor_) return;
    if (!monitor_(static_cast<std::ptrdiff_t>(bytes))) throw std::bad_alloc();
  }

  /// After memory was given back.
  void Give(std::size_t bytes) const {
    if (bytes > 0 && monitor_) monitor_(-static_cast<std::ptrdiff_t>(bytes));
  }

 private:
  MemoryMonitor monitor_;
};

/// Memory that has been asked for, until it is given back.
class MemoryClaim {
 public:
  MemoryClaim() = default;
  /// `account`, if there is one, must outlive it. Throws std::bad_alloc if the monitor refuses.
  MemoryClaim(std::size_t bytes, const MemoryAccount* account) : bytes_(bytes), account_(account) {
    if (account) account->Take(bytes);
  }
  ~MemoryClaim() {
    if (account_) account_->Give(bytes_);
  }
  MemoryClaim(MemoryClaim&& other) noexcept
      : bytes_(std::exchange(other.bytes_, 0)), account_(other.account_) {}
  MemoryClaim& operator=(MemoryClaim&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    std::swap(account_, other.account_);
    return *this;
  }

  std::size_t bytes() const { return bytes_; }

  /// Takes over another one of the same account.
  void Join(MemoryClaim&& other) { bytes_ += std::exchange(other.bytes_, 0); }

 private:
  std::size_t bytes_ = 0;
  const MemoryAccount* account_ = nullptr;
};

}  // namespace dacrt
