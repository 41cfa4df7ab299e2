// A clock that costs a third of the system's, for spans that are compared with each other.
#pragma once

#include <cstdint>

#if !defined(__x86_64__) && !defined(__i386__)
#include <chrono>
#endif

namespace dacrt {

/// Time stamps of the processor. How long a tick is, is not said.
inline uint64_t Ticks() {
#if defined(__x86_64__) || defined(__i386__)
  return __builtin_ia32_rdtsc();
#else
  return static_cast<uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace dacrt
