// Which of two ways rays go, where no rule knows which one is quicker.
//
// Rays of small calls that have next to nothing in common: alone, each takes the short way of a
// single ray, and the processor guesses where it goes; together, one is tested while another waits
// for memory. Which is quicker depends on how much they wait and how well they can be guessed.
//
// Rays that run close together and look for any hit: as groups that stay together, or as if they
// had nothing in common, which is quicker where they come apart before they are blocked.
//
// What rays hit does not depend on it.
#pragma once

#include <cstdint>

#include "runtime/ticks.h"
#include "trace/learnt_best.h"

namespace dacrt {

/// Learns by the time of some calls, and asks no clock in the others.
class LearntWay {
 public:
  /// When both are tried, so many rays go one way before as many go the other; in all each way gets
  /// `trial` rays of every `period`.
  explicit constexpr LearntWay(uint32_t run, uint32_t trial = 4096, uint32_t period = 1 << 19)
      : best_(trial, period, run), run_(run) {}

  /// How many rays at most are to go next: while both ways are tried the turns of each are to lie
  /// all over a call. The first way may be the quicker the more rays it gets, and has longer ones.
  uint32_t MostRays() const {
    if (!best_.is_trial()) return UINT32_MAX;
    return best_.Next() == 0 ? 8 * run_ : run_;
  }

  /// Takes so many rays one way or the other.
  template <class First, class Second>
  void Trace(uint32_t rays, const First& first, const Second& second) {
    const bool is_timed = best_.is_trial();
    const uint64_t start = is_timed ? Ticks() : 0;
    if (best_.Next() == 0) {
      first();
    } else {
      second();
    }
    best_.Count(is_timed ? Ticks() - start : 0, rays);
  }

 private:
  LearntBest<2> best_;  ///< batches are rays
  uint32_t run_;
};

}  // namespace dacrt
