// The hash multiplies 64-bit words into 128-bit products and folds these, as wyhash and others do.
// It is no defence against somebody who looks for collisions.
#include "shared_array.h"

#include <cstring>

namespace dacrt::mpi {
namespace {

// Odd numbers without a pattern: digits of the golden ratio, of pi, e and the square root of two.
constexpr uint64_t kSeeds[4] = {0x9e3779b97f4a7c15, 0x243f6a8885a308d3, 0xb7e151628aed2a6b,
                                0x6a09e667f3bcc909};

uint64_t Fold(uint64_t a, uint64_t b) {
  const auto product = static_cast<unsigned __int128>(a) * b;
  return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64);
}

}  // namespace

ArrayName NameOf(const ArraySource& source) {
  ArrayName name{{kSeeds[0], kSeeds[1]}, source.bytes()};
  const auto* item = static_cast<const std::byte*>(source.array.data);
  // Chains that depend on the whole past would wait for each product; four run beside each other.
  uint64_t lanes[4] = {kSeeds[0], kSeeds[1], kSeeds[2], kSeeds[3]};
  std::size_t lane = 0;
  for (std::size_t i = 0; i < source.count; ++i, item += source.array.stride) {
    for (std::size_t at = 0; at < source.item_bytes; at += 8) {
      uint64_t word = 0;
      if (at + 8 <= source.item_bytes) {
        std::memcpy(&word, item + at, 8);
      } else {
        std::memcpy(&word, item + at, 4);
      }
      lanes[lane] = Fold(lanes[lane] ^ word, kSeeds[3 - lane] | 1) + lanes[lane] + word;
      lane = (lane + 1) % 4;
    }
  }
  for (int half = 0; half < 2; ++half) {
    for (const uint64_t value : lanes) {
      name.hash[half] = Fold(name.hash[half] ^ value, kSeeds[2 + half]) + value;
    }
  }
  return name;
}

void CopyItems(const ArraySource& source, std::size_t first, std::size_t count, std::byte* to) {
  const auto* const start = static_cast<const std::byte*>(source.array.data);
  const auto* item = start + first * source.array.stride;
  if (source.array.stride == source.item_bytes) {
    std::memcpy(to, item, count * source.item_bytes);
    return;
  }
  for (std::size_t i = 0; i < count; ++i, item += source.array.stride, to += source.item_bytes) {
    std::memcpy(to, item, source.item_bytes);
  }
}

}  // namespace dacrt::mpi
