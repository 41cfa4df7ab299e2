// Waiting for other ranks: politely, because ranks may share processors, and not for ever.
#pragma once

#include <time.h>

#include <sched.h>
#include <chrono>

namespace dacrt::mpi {

using Clock = std::chrono::steady_clock;

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// How often the system is asked which processes are there.
inline constexpr double kLookSeconds = 0.02;

/// Lets others have the processor while there is nothing to do.
class Idle {
 public:
  /// Called when there was something to do.
  void Reset() { polls_ = 0; }

  /// Called when there was nothing.
  void Pause() {
    if (++polls_ <= kYields) {
      sched_yield();
      return;
    }
    const timespec time{0, polls_ <= kYields + kShortSleeps ? kShortSleep : kLongSleep};
    nanosleep(&time, nullptr);
  }

 private:
  // A message within a machine takes a few microseconds, so the first answer comes while yielding.
  // Naps of 20 us cost a twentieth of a processor; those of half a millisecond, next to nothing.
  static constexpr int kYields = 200;
  static constexpr int kShortSleeps = 2000;
  static constexpr long kShortSleep = 20'000;  // ns
  static constexpr long kLongSleep = 500'000;  // ns
  int polls_ = 0;
};

}  // namespace dacrt::mpi
