// Arrays that geometries refer to, as they travel: without gaps, and named by their contents.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#include "dacrt/geometry.h"

namespace dacrt::mpi {

/// Two arrays with one name are taken for the same: 128 bits of hash and the length.
struct ArrayName {
  uint64_t hash[2] = {0, 0};
  uint64_t bytes = 0;
  auto operator<=>(const ArrayName&) const = default;
};

/// `count` items of `item_bytes`, a multiple of four, which lie `array.stride` bytes apart.
struct ArraySource {
  Array array;
  std::size_t count = 0;
  std::size_t item_bytes = 0;

  std::size_t bytes() const { return count * item_bytes; }
};

ArrayName NameOf(const ArraySource& source);

/// Writes items first to first + count - 1 to `to`, without gaps.
void CopyItems(const ArraySource& source, std::size_t first, std::size_t count, std::byte* to);

}  // namespace dacrt::mpi
