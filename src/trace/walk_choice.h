// Whether rays that run close together go by groups or by lists.
//
// Groups are quicker where rays have most of their way in common, lists where they come apart. What
// a group visits does not tell which: what they cost is twice as much in one scene as in another
// with as many visits. So both are timed, on the way: from time to time some rays go by lists, and
// as long as those take less time, more and more do.
//
// What rays hit does not depend on it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "trace/policy.h"

namespace dacrt {

class WalkChoice {
 public:
  /// How many rays are to go by lists next; none if groups are.
  std::size_t rays_by_lists() const { return rays_by_lists_; }

  /// Some rays have gone by groups, which cannot be smaller.
  void CountGroups(std::size_t rays, uint64_t ticks, bool cannot_be_smaller) {
    groups_.Count(rays, ticks, policy::kKeptOfGroups);
    lists_.Forget(policy::kForgottenOfLists);
    if (++samples_ < policy::kSamplesOfGroups) return;
    if (cannot_be_smaller && lists_.mean() < groups_.mean()) rays_by_lists_ = run_;
  }

  /// Of those that were to, some have gone by lists.
  void CountLists(std::size_t rays, uint64_t ticks) {
    lists_.Count(rays, ticks, policy::kKeptOfLists);
    rays_by_lists_ -= std::min(rays, rays_by_lists_);
    if (rays_by_lists_ >= policy::kFewestByLists) return;
    rays_by_lists_ = 0;
    samples_ = 0;
    run_ = lists_.mean() < groups_.mean() ? std::min(2 * run_, policy::kMostByLists)
                                          : policy::kFewestByLists;
  }

 private:
  /// What a ray costs, of which the last ones count most.
  class Cost {
   public:
    float mean() const { return rays_ > 0 ? ticks_ / rays_ : 0; }

    /// Of what has been seen before, `kept` is kept. A thread that is interrupted says nothing.
    void Count(std::size_t rays, uint64_t ticks, float kept) {
      const auto more = static_cast<float>(rays);
      auto taken = static_cast<float>(ticks);
      if (rays_ > 0) taken = std::min(taken, policy::kMostOfMean * mean() * more);
      ticks_ = kept * ticks_ + taken;
      rays_ = kept * rays_ + more;
    }
    /// What was dear may not be so any more.
    void Forget(float part) { ticks_ -= part * ticks_; }

   private:
    float ticks_ = 0, rays_ = 0;
  };

  Cost groups_, lists_;
  std::size_t samples_ = 0;  ///< of groups since rays went by lists
  std::size_t run_ = policy::kFewestByLists;
  std::size_t rays_by_lists_ = 0;
};

}  // namespace dacrt
