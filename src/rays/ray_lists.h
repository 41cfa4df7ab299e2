// Memory for lists of rays.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rays/ray_record.h"

namespace dacrt {

/// Memory for the rays that are in an instance.
struct InstanceMemory {
  static constexpr std::size_t kRays = 256;

  RayRecord* rays;
  FullHit* hits;
  uint32_t* callers;  ///< the numbers of the caller's rays in the piece
  std::size_t count;  ///< rays that there is room for
};

/// Lists are stacked in [top, end).
struct ListMemory {
  std::byte* top;
  std::byte* end;
};

/// Entries that may be read or written behind the end of a list, and masks that have to be 0 there.
inline constexpr std::size_t kListSlack = 32;

/// What a visit of a node by `count` rays takes of the memory of lists at most: a byte of masks and
/// a number each, in whole cache lines.
constexpr std::size_t ListBytes(std::size_t count) {
  return (sizeof(uint8_t) + sizeof(RayNumber)) * (count + kListSlack) + 2 * 64;
}

}  // namespace dacrt
