// Numbers as people read them.
#pragma once

#include <cstddef>
#include <string>

namespace dacrt::bench {

/// With `digits` after the point.
std::string Fixed(double value, int digits);

/// With about three digits that count.
std::string Significant(double value);

/// A duration in seconds, to three significant digits or so.
std::string Seconds(double seconds);

/// As "2 threads".
std::string ThreadsText(int threads);

/// A count, its digits in groups of three.
std::string Grouped(std::size_t count);

/// N x N as "N^2".
std::string Squared(std::size_t side);

}  // namespace dacrt::bench
