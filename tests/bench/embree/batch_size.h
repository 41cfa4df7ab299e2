// How many rays a call takes: the columns of the matrix.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "ray_generation.h"

namespace dacrt::bench {

/// A size of batch and the picture whose rays fill it.
///
/// From kLeastPictureRays up a batch is a whole picture: a ray for each of its samples, or for each
/// hit. Smaller ones are what a renderer sends that works its way through a picture of
/// 512 x 512: consecutive slices of it, one call after the other.
struct BatchSize {
  static constexpr std::size_t kLeastPictureRays = 65'536;

  const char* name;
  std::size_t rays;

  bool IsSlice() const { return rays < kLeastPictureRays; }
  Raster Picture() const;

  /// Rays of one call, of a picture that makes `picture_rays` of this kind.
  std::size_t RaysOfCall(std::size_t picture_rays) const;
};

/// 64, 4K, 64K, 256K, 1M, 4M, 16M.
std::span<const BatchSize> BatchSizes();

/// Null if there is none of this name.
const BatchSize* FindBatchSize(const std::string& name);

}  // namespace dacrt::bench
