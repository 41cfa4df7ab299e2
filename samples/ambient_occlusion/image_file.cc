#include "ambient_occlusion/image_file.h"

#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <memory>
#include <string_view>

#include "ambient_occlusion/error.h"

namespace ao {
namespace {

namespace fs = std::filesystem;

Error OutputError(const fs::path& path, const std::string& what) {
  return Error(ExitCode::kOutput, path.string() + ": " + what);
}

std::string LowerCaseExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return extension;
}

bool HoldsLinearColor(const fs::path& path) { return LowerCaseExtension(path) == ".exr"; }

// IEC 61966-2-1.
float ToSrgb(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

// A file that is gone at the end unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const fs::path& beside)
      : path_(beside.parent_path() / (std::string(1, '.') + beside.stem().string() + '.' +
                                      std::to_string(getpid()) + beside.extension().string())) {}
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

ImageFile::ImageFile(const std::string& path) : path_(path) {
  constexpr std::array<std::string_view, 4> kExtensions = {".png", ".jpg", ".jpeg", ".exr"};
  if (std::find(kExtensions.begin(), kExtensions.end(), LowerCaseExtension(path_)) ==
      kExtensions.end()) {
    throw OutputError(path_, "the name must end in .png, .jpg, .jpeg or .exr");
  }
  std::error_code error;
  if (!fs::is_directory(fs::absolute(path_).parent_path(), error))
    throw OutputError(path_, "there is no such folder");
  if (fs::is_directory(path_, error)) throw OutputError(path_, "this is a folder");
  // Permissions alone do not tell, so a file is made, and is gone again.
  const TemporaryFile probe(path_);
  if (!std::ofstream(probe.path())) throw OutputError(path_, "the folder cannot be written to");
}

void ImageFile::Write(const Image& image) const {
  const TemporaryFile temporary(path_);
  const std::unique_ptr<OIIO::ImageOutput> output =
      OIIO::ImageOutput::create(temporary.path().string());
  if (!output) throw OutputError(path_, OIIO::geterror());

  std::vector<float> encoded;
  const float* pixels = image.pixels.data();
  OIIO::ImageSpec spec(int(image.width), int(image.height), 3, OIIO::TypeDesc::HALF);
  if (!HoldsLinearColor(path_)) {
    spec.set_format(OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("CompressionQuality", 95);
    encoded.resize(image.pixels.size());
    std::transform(image.pixels.begin(), image.pixels.end(), encoded.begin(), ToSrgb);
    pixels = encoded.data();
  }
  if (!output->open(temporary.path().string(), spec) ||
      !output->write_image(OIIO::TypeDesc::FLOAT, pixels) || !output->close()) {
    throw OutputError(path_, "cannot be written: " + output->geterror());
  }
  std::error_code error;
  fs::rename(temporary.path(), path_, error);
  if (error) throw OutputError(path_, "cannot be written: " + error.message());
}

}  // namespace ao
