// What a thread remembers from call to call, told by where its stack is: thread-local memory would
// cost a single ray more to find. Threads that share a slot must lose nothing but time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dacrt {

inline constexpr unsigned kLogStackSlots = 6;
inline constexpr std::size_t kStackSlots = std::size_t{1} << kLogStackSlots;

/// The slot of the caller's thread, below kStackSlots.
[[gnu::always_inline]] inline std::size_t SlotOfThisStack() {
  const auto place = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0)) >> 16;
  return static_cast<uint32_t>(place) * 0x9E3779B1u >> (32 - kLogStackSlots);
}

}  // namespace dacrt
