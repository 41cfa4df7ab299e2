// Which rays of a batch a direct solve is for.
#pragma once

#include <cstddef>
#include <cstdint>

#include "rays/ray_batch.h"

namespace dacrt {

/// The rays in slots [begin, begin + count); of up to 64, only those whose bit in `lanes` is set.
struct RaySelection {
  std::size_t begin;
  std::size_t count;
  uint64_t lanes = ~uint64_t{0};

  static RaySelection All(const RayBlock& block) { return {block.begin, block.count}; }
  static RaySelection Lanes(std::size_t begin, uint64_t lanes) { return {begin, 64, lanes}; }
};

/// Calls `function(slot)` for each ray that has not been blocked.
template <class Function>
void ForEachRay(const RaySelection& rays, const Function& function) {
  if (rays.count > 64 || rays.lanes == ~uint64_t{0}) {
    for (std::size_t slot = rays.begin; slot < rays.begin + rays.count; ++slot) function(slot);
    return;
  }
  std::size_t slot = rays.begin;
  for (uint64_t lanes = rays.lanes; lanes != 0; lanes >>= 1, ++slot) {
    if (lanes & 1) function(slot);
  }
}

}  // namespace dacrt
