#include "embree_library.h"

namespace dacrt::bench {

EmbreeLibrary::EmbreeLibrary(const std::string& path, const std::string& config)
    : api_(std::make_unique<tests::EmbreeApi>(tests::LoadEmbree(path))),
      device_(std::make_unique<tests::EmbreeDevice>(*api_, config)) {}

std::string DeviceConfig(const std::string& isa, int threads) {
  return "threads=" + std::to_string(threads) + ",isa=" + isa;
}

}  // namespace dacrt::bench
