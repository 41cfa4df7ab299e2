#include "dacrt/statistics.h"

#include <gtest/gtest.h>

#include <cstring>

namespace dacrt {
namespace {

// Every member has eight bytes, and each but the depth is a sum: so a member that operator+=
// forgets is found without being named here.
TEST(StatisticsTest, AddingAddsEveryMemberAndKeepsTheLargerDepth) {
  constexpr std::size_t kMembers = sizeof(Statistics) / 8;
  static_assert(sizeof(Statistics) % 8 == 0);
  const std::size_t first_second = offsetof(Statistics, seconds_loading) / 8;
  const auto member = [](Statistics& s, std::size_t i) {
    return reinterpret_cast<char*>(&s) + 8 * i;
  };
  const auto fill = [&](uint64_t factor) {
    Statistics s;
    for (std::size_t i = 0; i < kMembers; ++i) {
      const uint64_t count = factor * (i + 1);
      const double seconds = static_cast<double>(count);
      std::memcpy(member(s, i), i < first_second ? static_cast<const void*>(&count) : &seconds, 8);
    }
    return s;
  };
  Statistics sum = fill(10);
  sum += fill(100);
  Statistics expected = fill(110);
  expected.max_depth = fill(100).max_depth;
  for (std::size_t i = 0; i < kMembers; ++i) {
    EXPECT_EQ(std::memcmp(member(sum, i), member(expected, i), 8), 0) << "member " << i;
  }
  sum += Statistics();
  EXPECT_EQ(sum.max_depth, expected.max_depth);
}

}  // namespace
}  // namespace dacrt
