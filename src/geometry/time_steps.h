// When a geometry that moves stands where.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "dacrt/transform.h"

namespace dacrt {

/// A time between two time steps: `fraction` of the way from `step` to the one behind it.
struct Moment {
  uint32_t step = 0;
  float fraction = 0;
};

/// The time steps of a geometry, which stand at equal distances in its time range.
class TimeSteps {
 public:
  TimeSteps(uint32_t count, const TimeRange& range) : count_(count), range_(range) {}

  /// Nothing if the geometry is not there at `time`.
  std::optional<Moment> At(float time) const {
    if (count_ == 1) return Moment{};
    if (!(time >= range_.begin && time <= range_.end)) return std::nullopt;
    const float segments = static_cast<float>(count_ - 1);
    const float place = (time - range_.begin) / (range_.end - range_.begin) * segments;
    // A range of no length is at its first step.
    if (std::isnan(place)) return Moment{};
    if (count_ == 2) return Moment{0, place};
    const float step = std::min(std::max(std::floor(place), 0.0f), segments - 1);
    return Moment{static_cast<uint32_t>(step), place - step};
  }

 private:
  uint32_t count_;
  TimeRange range_;
};

}  // namespace dacrt
