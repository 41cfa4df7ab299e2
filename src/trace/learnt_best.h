// Which of several ways costs least, where no rule knows it beforehand: a few batches in a row go
// each way, those after them the cheapest.
#pragma once

#include <algorithm>
#include <cstdint>

namespace dacrt {

template <uint32_t kWays>
class LearntBest {
 public:
  /// Each of the ways gets `trials` of every `period` batches, or what counts as so many; at first
  /// of fewer, but not of the first ones: batches for which nodes are made cost something else than
  /// those that follow. They go one way until `run` are done, then the next: a processor guesses
  /// well where it was a moment before.
  constexpr LearntBest(uint32_t trials, uint32_t period, uint32_t run = 1)
      : trial_end_(kWays * trials),
        most_(period),
        run_(run),
        period_(2 * trial_end_),
        done_(trial_end_) {}

  uint32_t best() const { return best_; }

  /// For the next batch.
  uint32_t Next() const { return is_trial_ ? turn_ : best_; }

  /// Whether anybody wants to know what it costs.
  bool is_trial() const { return is_trial_; }

  /// What that batch has cost, which counts as `count` ones.
  void Count(uint64_t cost, uint32_t count = 1) {
    done_ += count;
    if (is_trial_) {
      costs_[turn_] += cost;
      counts_[turn_] += count;
      run_done_ += count;
      if (run_done_ < run_) return;
      run_done_ = 0;
      turn_ = (turn_ + 1) % kWays;
      if (turn_ == 0 && done_ >= trial_end_) Decide();
    }
    if (is_trial_ || done_ < period_) return;
    done_ = 0;
    is_trial_ = true;
    period_ = std::min(2 * period_, most_);
  }

 private:
  void Decide() {
    const auto mean = [&](uint32_t i) {
      return static_cast<double>(costs_[i]) / static_cast<double>(counts_[i]);
    };
    best_ = 0;
    for (uint32_t i = 1; i < kWays; ++i) {
      if (mean(i) < mean(best_)) best_ = i;
    }
    // What was seen before counts half as much the next time.
    for (uint64_t& cost : costs_) cost /= 2;
    for (uint64_t& count : counts_) count /= 2;
    is_trial_ = false;
  }

  uint32_t trial_end_;
  uint32_t most_;
  uint32_t run_;
  uint32_t period_;  ///< this time, up to that
  uint32_t done_;    ///< of it
  bool is_trial_ = false;
  uint32_t turn_ = 0;      ///< whose it is in a trial
  uint32_t run_done_ = 0;  ///< of its run
  uint64_t costs_[kWays] = {}, counts_[kWays] = {};
  uint32_t best_ = 0;
};

}  // namespace dacrt
