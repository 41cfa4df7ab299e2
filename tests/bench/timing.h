// Wall-clock time, and what to report of several measurements.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace dacrt::bench {

/// Runs from its construction on.
class Stopwatch {
 public:
  double Seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// Of an even number, the smaller of the two in the middle. `values` must not be empty.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + (values.size() - 1) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// `values` must not be empty.
inline double GeometricMean(const std::vector<double>& values) {
  double logarithms = 0;
  for (const double value : values) logarithms += std::log(value);
  return std::exp(logarithms / values.size());
}

}  // namespace dacrt::bench
