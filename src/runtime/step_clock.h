// Where the time of a call goes, step by step, cheap enough to be always on.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "runtime/ticks.h"

namespace dacrt {

enum class Step { kLoading, kSampling, kBinning, kPartition, kFiltering, kDirect, kStoring };

/// Ticks spent in each step. How long a tick is comes out at the end, from the span of the whole
/// call in the system's clock, too.
class StepClock {
 public:
  static constexpr std::size_t kSteps = 7;

  /// Charges its own lifetime to a step.
  class Charge {
   public:
    Charge(StepClock& clock, Step step) : clock_(clock), step_(step), start_(Ticks()) {}
    ~Charge() { clock_.ticks_[static_cast<std::size_t>(step_)] += Ticks() - start_; }
    Charge(const Charge&) = delete;
    Charge& operator=(const Charge&) = delete;

   private:
    StepClock& clock_;
    Step step_;
    uint64_t start_;
  };

  /// Seconds of each step, in the order of the enumeration, as of now.
  std::array<double, kSteps> Seconds() const {
    const std::chrono::duration<double> span = std::chrono::steady_clock::now() - started_;
    const uint64_t ticks = Ticks() - start_;
    std::array<double, kSteps> seconds{};
    for (std::size_t step = 0; step < kSteps && ticks > 0; ++step) {
      seconds[step] = static_cast<double>(ticks_[step]) * span.count() / static_cast<double>(ticks);
    }
    return seconds;
  }

 private:
  std::array<uint64_t, kSteps> ticks_{};
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  uint64_t start_ = Ticks();
};

}  // namespace dacrt
