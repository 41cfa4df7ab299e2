// Writing the picture.
#pragma once

#include <filesystem>
#include <string>

#include "ambient_occlusion/render.h"

namespace ao {

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
