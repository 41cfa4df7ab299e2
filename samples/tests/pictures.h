// Reading and comparing pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace sample_test {

struct Picture {
  int width;
  int height;
  int channels;
  bool is_half;                // else 8 bits
  std::vector<float> samples;  // 0 to 255 of 8 bits; as they are of half floats
};

// Fails the test and returns an empty picture if it cannot be read.
Picture ReadPicture(const std::filesystem::path& path);

struct Difference {
  uint64_t pixels = 0;  // that differ at all
  float largest = 0;    // in one channel
};

// The pictures must be of the same size.
Difference Compare(const Picture& a, const Picture& b);

}  // namespace sample_test
