#include "runtime/assert.h"

#include <gtest/gtest.h>

namespace dacrt {
namespace {

// Invariants are checked where that was asked for, and cost nothing where it was not.
TEST(AssertDeathTest, EndsTheProcessWhereInvariantsAreChecked) {
  int evaluated = 0;
  const auto is_kept = [&](bool kept) {
    ++evaluated;
    return kept;
  };
  DACRT_ASSERT(is_kept(true));
#if defined(DACRT_ASSERTIONS) || !defined(NDEBUG)
  EXPECT_EQ(evaluated, 1);
  EXPECT_DEATH(DACRT_ASSERT(is_kept(false)), "assert_test.cc.*dacrt relies on: is_kept\\(false\\)");
#else
  DACRT_ASSERT(is_kept(false));
  EXPECT_EQ(evaluated, 0);
#endif
}

}  // namespace
}  // namespace dacrt
