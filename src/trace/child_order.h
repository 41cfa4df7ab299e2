// In which order the children of a node are visited by rays that look for any hit.
//
// The order decides how soon a blocked ray is done, and no rule knows it beforehand: for shadows
// the nearest child holds the surface that the rays come from, the farthest what stands around the
// light, and each order takes twice the time of another one in some scene. So it is learnt: a few
// groups or pieces of rays in a row go by each order, those after them by the cheapest.
//
// What any-hit rays find does not depend on it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dacrt {

enum class ChildOrder : uint8_t { kAsStored, kNearestFirst, kFarthestFirst };

class LearntOrder {
 public:
  static constexpr uint32_t kOrders = 3;

  /// Each order gets `trials` of every `period` batches.
  constexpr LearntOrder(uint32_t trials, uint32_t period)
      : trial_end_(kOrders * trials), period_(period) {}

  ChildOrder best() const { return best_; }

  /// For the next batch.
  ChildOrder Next() const { return IsTrial() ? static_cast<ChildOrder>(done_ % kOrders) : best_; }

  /// What that batch has cost.
  void Count(uint64_t cost) {
    if (IsTrial()) costs_[done_ % kOrders] += cost;
    if (++done_ == trial_end_) Decide();
    if (done_ == period_) done_ = 0;
  }

 private:
  bool IsTrial() const { return done_ < trial_end_; }

  void Decide() {
    best_ = ChildOrder::kAsStored;
    for (uint32_t i = 1; i < kOrders; ++i) {
      if (costs_[i] < costs_[static_cast<uint32_t>(best_)]) best_ = static_cast<ChildOrder>(i);
    }
    // What was seen before counts half as much the next time.
    for (uint64_t& cost : costs_) cost /= 2;
  }

  uint32_t trial_end_;
  uint32_t period_;
  uint32_t done_ = 0;
  uint64_t costs_[kOrders] = {};
  ChildOrder best_ = ChildOrder::kAsStored;
};

/// What a thread has learnt about a scene.
struct LearntOrders {
  LearntOrder of_groups{8, 2048};  ///< costs are visits
  LearntOrder of_pieces{1, 64};    ///< costs are box tests a ray
};

/// Those of the calling thread for a scene that it asks for by an address: calls are often smaller
/// than what it takes to learn. It may forget, and may confuse scenes.
LearntOrders& LearntOrdersOf(const void* scene);

}  // namespace dacrt
