// Invariants, checked where they are relied on: in debug builds, and under sanitizers with the CMake
// option DACRT_ASSERTIONS. Other builds compile the conditions and leave them out.
#pragma once

#include <cstdio>
#include <cstdlib>

#if defined(DACRT_ASSERTIONS) || !defined(NDEBUG)
#define DACRT_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : dacrt::FailAssertion(#condition, __FILE__, __LINE__))
#else
#define DACRT_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#endif

namespace dacrt {

[[noreturn]] inline void FailAssertion(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: dacrt relies on: %s\n", file, line, condition);
  std::abort();
}

}  // namespace dacrt
