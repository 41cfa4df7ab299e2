// How dacrt-compare ends: as the benchmarks (errors.h), and with two more.
#pragma once

#include <stdexcept>

namespace dacrt::compare {

inline constexpr int kProgramFailed = 6;  ///< cannot be started, or cannot be compared
inline constexpr int kNotForDacrt = 7;    ///< runs with Embree, and does not with dacrt

/// A program that cannot be started, or tells nothing. The message names it and the reason.
class ProgramError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace dacrt::compare
