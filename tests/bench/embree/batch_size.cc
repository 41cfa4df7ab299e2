#include "batch_size.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace dacrt::bench {
namespace {

constexpr BatchSize kBatchSizes[] = {{"1", 1},
                                     {"4", 4},
                                     {"8", 8},
                                     {"16", 16},
                                     {"64", 8 * 8},
                                     {"1K", 32 * 32},
                                     {"4K", 64 * 64},
                                     {"64K", 256 * 256},
                                     {"256K", 512 * 512},
                                     {"1M", 1024 * 1024},
                                     {"4M", 2048 * 2048},
                                     {"16M", 4096 * 4096}};

// Single rays and packets that a program sends before it looks at their results.
constexpr std::size_t kRaysOfCalls = 16'384;

using Form = Call::Form;
constexpr Call kSingle[] = {kSingleRays};
constexpr Call kPackets4[] = {{Form::kPackets4}, {Form::kPackets4, true}};
constexpr Call kPackets8[] = {{Form::kPackets8}, {Form::kPackets8, true}};
constexpr Call kPackets16[] = {{Form::kPackets16}, {Form::kPackets16, true}};
constexpr Call kStreams[] = {kIncoherentStream, kCoherentStream, kSingleRays};

}  // namespace

std::uint32_t BatchSize::PictureSide(std::uint32_t sliced_side) const {
  return IsSlice() ? sliced_side : static_cast<std::uint32_t>(std::lround(std::sqrt(rays)));
}

std::size_t BatchSize::RaysOfBatch(std::size_t picture_rays) const {
  if (!IsStream()) return std::min(kRaysOfCalls, picture_rays) / rays * rays;
  return IsSlice() ? std::min(rays, picture_rays) : picture_rays;
}

std::size_t BatchSize::RaysOfRun(std::size_t picture_rays, int threads) const {
  const std::size_t batch = RaysOfBatch(picture_rays);
  if (threads == 1 || !IsStream() || !IsSlice()) return batch;
  return std::max(std::min(kRaysOfCalls, picture_rays) / batch, std::size_t{1}) * batch;
}

std::span<const Call> BatchSize::Calls() const {
  switch (rays) {
    case 1:
      return kSingle;
    case 4:
      return kPackets4;
    case 8:
      return kPackets8;
    case 16:
      return kPackets16;
    default:
      return kStreams;
  }
}

std::span<const BatchSize> BatchSizes() { return kBatchSizes; }

const BatchSize* FindBatchSize(const std::string& name) {
  const auto found = std::ranges::find(kBatchSizes, name, &BatchSize::name);
  return found == std::end(kBatchSizes) ? nullptr : found;
}

}  // namespace dacrt::bench
