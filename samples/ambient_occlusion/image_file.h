// Writing the picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ao {

struct Image {
  uint32_t width;
  uint32_t height;
  std::vector<float> pixels;  // linear red, green, blue, row after row from the top
};

// A picture to be written: PNG and JPEG hold 8 bits in sRGB, OpenEXR linear half floats.
class ImageFile {
 public:
  // Throws Error with kOutput if a picture could not be written there: an unknown extension, no
  // such folder, no permission.
  explicit ImageFile(const std::string& path);

  // Writes to a file beside and renames it when complete: there is never half a picture.
  // Throws Error with kOutput.
  void Write(const Image& image) const;

 private:
  std::filesystem::path path_;
};

}  // namespace ao
