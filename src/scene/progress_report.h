// How far a call is, for the program that asked for it.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>

#include "dacrt/dacrt.h"

namespace dacrt {

/// Tells the program how far a call is, and hears whether it is to go on.
class ProgressReport {
 public:
  ProgressReport(const Progress& progress, std::size_t rays) : progress_(progress), rays_(rays) {}

  bool goes_on() const { return goes_on_; }

  /// After a piece of `rays`.
  void Add(std::size_t rays) {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    done_ += rays;
    if (goes_on_ && !progress_(done_, rays_)) goes_on_ = false;
  }

 private:
  const Progress progress_;
  const std::size_t rays_;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::atomic<bool> goes_on_{true};
};

}  // namespace dacrt
