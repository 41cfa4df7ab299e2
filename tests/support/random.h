// A small generator of random numbers: the same sequence with every standard library, so that a
// seed names the same scene and the same rays everywhere.
#pragma once

#include <cstdint>
#include <string_view>

namespace dacrt::tests {

/// SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t Next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

  uint32_t Bits() { return static_cast<uint32_t>(Next() >> 32); }

  /// In [0, count). `count` must not be 0.
  uint32_t Below(uint32_t count) {
    return static_cast<uint32_t>((static_cast<uint64_t>(Bits()) * count) >> 32);
  }

  /// In [0, 1).
  float Uniform() { return static_cast<float>(Next() >> 40) * 0x1p-24f; }

  /// In [lower, upper], up to rounding.
  float Uniform(float lower, float upper) { return lower + (upper - lower) * Uniform(); }

  bool Chance(float probability) { return Uniform() < probability; }

 private:
  uint64_t state_;
};

/// A seed for what `name` stands for, independent of the seeds for other names (FNV-1a).
inline uint64_t SeedFor(std::string_view name, uint64_t seed) {
  uint64_t hash = 0xcbf29ce484222325u ^ seed;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return Random(hash).Next();
}

}  // namespace dacrt::tests
