#include "batch_size.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace dacrt::bench {
namespace {

constexpr std::size_t kSlicedPictureRays = 512 * 512;

constexpr BatchSize kBatchSizes[] = {{"64", 8 * 8},       {"4K", 64 * 64},     {"64K", 256 * 256},
                                     {"256K", 512 * 512}, {"1M", 1024 * 1024}, {"4M", 2048 * 2048},
                                     {"16M", 4096 * 4096}};

}  // namespace

Raster BatchSize::Picture() const {
  const std::size_t picture_rays = IsSlice() ? kSlicedPictureRays : rays;
  return Raster(static_cast<uint32_t>(std::lround(std::sqrt(picture_rays))));
}

std::size_t BatchSize::RaysOfCall(std::size_t picture_rays) const {
  return IsSlice() ? std::min(rays, picture_rays) : picture_rays;
}

std::span<const BatchSize> BatchSizes() { return kBatchSizes; }

const BatchSize* FindBatchSize(const std::string& name) {
  const auto found = std::ranges::find(kBatchSizes, name, &BatchSize::name);
  return found == std::end(kBatchSizes) ? nullptr : found;
}

}  // namespace dacrt::bench
