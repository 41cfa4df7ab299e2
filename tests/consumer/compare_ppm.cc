// usage: compare_ppm A.ppm B.ppm COUNT
//
// Succeeds if the two pictures have the same size, no channel of a pixel differs by more than one
// step, and at most COUNT pixels differ.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Picture {
  int width = 0, height = 0;
  std::vector<unsigned char> channels;  ///< three a pixel
};

Picture ReadPicture(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  Picture picture;
  std::string magic;
  int maximum = 0;
  file >> magic >> picture.width >> picture.height >> maximum;
  file.get();  // the white space that ends the header
  if (!file || magic != "P6" || maximum != 255) throw std::runtime_error(path + " is no 8-bit PPM");
  picture.channels.resize(3 * std::size_t(picture.width) * std::size_t(picture.height));
  file.read(reinterpret_cast<char*>(picture.channels.data()),
            static_cast<std::streamsize>(picture.channels.size()));
  if (!file) throw std::runtime_error(path + " is truncated");
  return picture;
}

/// The number of pixels that differ, by one step; throws if one differs by more.
std::size_t CountDifferences(const Picture& a, const Picture& b) {
  if (a.width != b.width || a.height != b.height) throw std::runtime_error("sizes differ");
  std::size_t different_pixels = 0;
  for (std::size_t pixel = 0; pixel < a.channels.size(); pixel += 3) {
    int largest = 0;
    for (std::size_t i = pixel; i < pixel + 3; ++i) {
      largest = std::max(largest, std::abs(int(a.channels[i]) - int(b.channels[i])));
    }
    if (largest > 1) {
      throw std::runtime_error("pixel " + std::to_string(pixel / 3) + " differs by " +
                               std::to_string(largest) + " steps");
    }
    different_pixels += largest == 1;
  }
  return different_pixels;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("usage: compare_ppm A.ppm B.ppm COUNT");
  const std::size_t differences = CountDifferences(ReadPicture(argv[1]), ReadPicture(argv[2]));
  std::cout << differences << " pixels differ by one step\n";
  return differences <= std::stoul(argv[3]) ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << "compare_ppm: " << error.what() << "\n";
  return 1;
}
