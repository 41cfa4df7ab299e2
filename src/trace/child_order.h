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

  /// Each of the orders gets `trials` of every `period` batches; at first of fewer, since batches
  /// for which nodes are made cost something else than those that follow.
  constexpr LearntOrder(uint32_t trials, uint32_t period)
      : trial_end_(kOrders * trials), most_(period), period_(2 * trial_end_) {}

  ChildOrder best() const { return static_cast<ChildOrder>(best_); }

  /// For the next batch.
  ChildOrder Next() const { return IsTrial() ? static_cast<ChildOrder>(done_ % kOrders) : best(); }

  /// What that batch has cost.
  void Count(uint64_t cost) {
    if (IsTrial()) costs_[done_ % kOrders] += cost;
    if (++done_ == trial_end_) Decide();
    if (done_ < period_) return;
    done_ = 0;
    period_ = std::min(2 * period_, most_);
  }

 private:
  bool IsTrial() const { return done_ < trial_end_; }

  void Decide() {
    best_ = 0;
    for (uint32_t i = 1; i < kOrders; ++i) {
      if (costs_[i] < costs_[best_]) best_ = i;
    }
    // What was seen before counts half as much the next time.
    for (uint64_t& cost : costs_) cost /= 2;
  }

  uint32_t trial_end_;
  uint32_t most_;
  uint32_t period_;  ///< the next time, up to that
  uint32_t done_ = 0;
  uint64_t costs_[kOrders] = {};
  uint32_t best_ = 0;
};

}  // namespace dacrt
