// Memory for lists of rays.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rays/ray_record.h"

namespace dacrt {

/// Memory for the rays that are in an instance.
struct InstanceMemory {
  /// At most. With 256, 1,024, 4,096 and 16,384, rays of calls of 64K took 155, 132, 123 and 122 ns
  /// (ambient) and 389, 326, 293 and 292 (diffuse) of a hall that is one instance.
  static constexpr std::size_t kRays = 4096;

  RayRecord* rays;
  FullHit* hits;
  RayNumber* outer_rays;  ///< their numbers outside
  std::size_t count;      ///< rays that there is room for
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
