// How to move the lanes of a vector whose bits are set to its front.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dacrt {

/// Of eight lanes of 16 bits, bytes for each of the 256 sets. (Highway's Compress, in the version
/// of Debian 12, copies its table to the stack whenever it is called.)
struct CompressTable {
  alignas(16) uint8_t bytes[256][16];

  constexpr CompressTable() : bytes() {
    for (std::size_t bits = 0; bits < 256; ++bits) {
      std::size_t place = 0;
      for (std::size_t lane = 0; lane < 8; ++lane) {
        if (!(bits >> lane & 1)) continue;
        bytes[bits][place++] = static_cast<uint8_t>(2 * lane);
        bytes[bits][place++] = static_cast<uint8_t>(2 * lane + 1);
      }
    }
  }
};
inline constexpr CompressTable kCompressTable;

}  // namespace dacrt
