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

}  // namespace dacrt
