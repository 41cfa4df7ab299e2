// In which order the children of a node are visited by rays that look for any hit.
//
// The order decides how soon a blocked ray is done, and no rule knows it beforehand: for shadows
// the nearest child holds the surface that the rays come from, the farthest what stands around the
// light, and each order takes twice the time of another one in some scene. So it is learnt: a few
// groups or pieces of rays in a row go by each order, those after them by the cheapest.
//
// What any-hit rays find does not depend on it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace dacrt {

/// As stored: see SortChildren in partition/choose_nodes-inl.h. Single rays always go so: distances
/// would have to be stored.
enum class ChildOrder : uint8_t { kAsStored, kNearestFirst, kFarthestFirst };

class LearntOrder {
 public:
  static constexpr uint32_t kOrders = 3;

  /// Each of the orders gets `trials` of every `period` batches, or what counts as so many; at
  /// first of fewer, but not of the first ones: batches for which nodes are made cost something
  /// else than those that follow.
  constexpr LearntOrder(uint32_t trials, uint32_t period)
      : trial_end_(kOrders * trials), most_(period), period_(2 * trial_end_), done_(trial_end_) {}

  ChildOrder best() const { return static_cast<ChildOrder>(best_); }

  /// For the next batch.
  ChildOrder Next() const { return is_trial_ ? static_cast<ChildOrder>(turn_) : best(); }

  /// What that batch has cost, which counts as `count` ones.
  void Count(uint64_t cost, uint32_t count = 1) {
    done_ += count;
    if (is_trial_) {
      costs_[turn_] += cost;
      counts_[turn_] += count;
      turn_ = (turn_ + 1) % kOrders;
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
    for (uint32_t i = 1; i < kOrders; ++i) {
      if (mean(i) < mean(best_)) best_ = i;
    }
    // What was seen before counts half as much the next time.
    for (uint64_t& cost : costs_) cost /= 2;
    for (uint64_t& count : counts_) count /= 2;
    is_trial_ = false;
  }

  uint32_t trial_end_;
  uint32_t most_;
  uint32_t period_;  ///< this time, up to that
  uint32_t done_;    ///< of it
  bool is_trial_ = false;
  uint32_t turn_ = 0;  ///< whose it is in a trial
  uint64_t costs_[kOrders] = {}, counts_[kOrders] = {};
  uint32_t best_ = 0;
};

}  // namespace dacrt
