// How many rays a call takes: the columns of the matrix.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "ray_call.h"
#include "ray_generation.h"

namespace dacrt::bench {

/// A size of call and the picture whose rays fill it.
///
/// From kLeastPictureRays up a call is a whole picture: a ray for each of its samples, or for each
/// hit. Smaller ones are what a renderer sends that works its way through a picture: consecutive
/// slices of it, one call after the other. Below kLeastStreamRays they are single rays and packets,
/// which have calls of their own.
struct BatchSize {
  static constexpr std::size_t kLeastStreamRays = 64;
  static constexpr std::size_t kLeastPictureRays = 65'536;

  const char* name;
  std::size_t rays;

  bool IsStream() const { return rays >= kLeastStreamRays; }
  bool IsSlice() const { return rays < kLeastPictureRays; }

  /// Along one side; of a picture that is sliced, `sliced_side`.
  std::uint32_t PictureSide(std::uint32_t sliced_side) const;

  /// Rays that a program has at a time, of a picture that makes `picture_rays` of this kind: those
  /// of a stream call, or some thousands of single rays or in full packets.
  std::size_t RaysOfBatch(std::size_t picture_rays) const;

  /// Rays that `threads` share out in calls of this size, on a still scene, before one of them
  /// waits for another: a batch, or where this is one small stream, some thousands in many of them.
  std::size_t RaysOfRun(std::size_t picture_rays, int threads) const;

  /// The calls by which a program may send as many rays at a time: a stream as single rays, too.
  std::span<const Call> Calls() const;
};

/// 1, 4, 8, 16, 64, 1K, 4K, 64K, 256K, 1M, 4M, 16M.
std::span<const BatchSize> BatchSizes();

/// Null if there is none of this name.
const BatchSize* FindBatchSize(const std::string& name);

}  // namespace dacrt::bench
