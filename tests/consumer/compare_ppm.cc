// usage: compare_ppm A.ppm B.ppm COUNT OUTLIERS
//
// Succeeds if the two pictures have the same size and show something, at most COUNT pixels differ,
// and at most OUTLIERS of them by more than one step of a channel.
#include <algorithm>
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

/// Throws if all pixels are the same.
void CheckThatItShowsSomething(const Picture& picture) {
  for (std::size_t i = 3; i < picture.channels.size(); ++i) {
    if (picture.channels[i] != picture.channels[i - 3]) return;
  }
  throw std::runtime_error("the picture is empty");
}

struct Differences {
  std::size_t pixels = 0;
  std::size_t outliers = 0;  ///< pixels that differ by more than one step
  int worst = 0;             ///< steps
};

Differences CountDifferences(const Picture& a, const Picture& b) {
  if (a.width != b.width || a.height != b.height) throw std::runtime_error("sizes differ");
  Differences differences;
  for (std::size_t pixel = 0; pixel < a.channels.size(); pixel += 3) {
    int largest = 0;
    for (std::size_t i = pixel; i < pixel + 3; ++i) {
      largest = std::max(largest, std::abs(int(a.channels[i]) - int(b.channels[i])));
    }
    differences.pixels += largest > 0;
    differences.outliers += largest > 1;
    differences.worst = std::max(differences.worst, largest);
  }
  return differences;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 5) throw std::runtime_error("usage: compare_ppm A.ppm B.ppm COUNT OUTLIERS");
  const Picture a = ReadPicture(argv[1]);
  CheckThatItShowsSomething(a);
  const Differences differences = CountDifferences(a, ReadPicture(argv[2]));
  std::cout << differences.pixels << " pixels differ, " << differences.outliers
            << " by more than one step, the worst by " << differences.worst << "\n";
  const bool same =
      differences.pixels <= std::stoul(argv[3]) && differences.outliers <= std::stoul(argv[4]);
  return same ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << "compare_ppm: " << error.what() << "\n";
  return 1;
}
