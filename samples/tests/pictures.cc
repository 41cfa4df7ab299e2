#include "tests/pictures.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace sample_test {

Picture ReadPicture(const std::filesystem::path& path) {
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path.string());
  if (!input) {
    ADD_FAILURE() << path << ": " << OIIO::geterror();
    return {};
  }
  const OIIO::ImageSpec& spec = input->spec();
  Picture picture{spec.width, spec.height, spec.nchannels, spec.format == OIIO::TypeDesc::HALF,
                  std::vector<float>(size_t(spec.image_pixels()) * spec.nchannels)};
  EXPECT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, picture.samples.data()))
      << path << ": " << input->geterror();
  if (!picture.is_half) {
    for (float& sample : picture.samples) sample = std::round(sample * 255);
  }
  return picture;
}

Difference Compare(const Picture& a, const Picture& b) {
  Difference difference;
  for (size_t pixel = 0; pixel < a.samples.size(); pixel += a.channels) {
    float largest = 0;
    for (int channel = 0; channel < a.channels; ++channel) {
      const size_t i = pixel + channel;
      largest = std::max(largest, std::abs(a.samples[i] - b.samples[i]));
    }
    difference.pixels += largest > 0;
    difference.largest = std::max(difference.largest, largest);
  }
  return difference;
}

}  // namespace sample_test
