#include "lidar/cloud_file.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <system_error>
#include <vector>

#include "ambient_occlusion/error.h"

namespace lidar {
namespace {

namespace fs = std::filesystem;
using ao::Error;
using ao::ExitCode;

static_assert(std::endian::native == std::endian::little, "as the header says");

constexpr size_t kPointBytes = 3 * sizeof(float) + 2;

Error OutputError(const fs::path& path, const std::string& what) {
  return Error(ExitCode::kOutput, path.string() + ": " + what);
}

}  // namespace

CloudFile::CloudFile(const std::string& path) : path_(path) {
  if (path_.extension() != ".ply") throw OutputError(path_, "the name must end in .ply");
  std::error_code error;
  if (!fs::is_directory(fs::absolute(path_).parent_path(), error)) {
    throw OutputError(path_, "there is no such folder");
  }
  const bool is_there = fs::exists(path_, error);
  // For appending: an older file stays until there is a new one.
  if (!std::ofstream(path_, std::ios::app)) throw OutputError(path_, "cannot be written");
  if (!is_there) fs::remove(path_, error);
}

void CloudFile::Write(std::span<const Point> points) const {
  std::vector<char> bytes(points.size() * kPointBytes);
  char* to = bytes.data();
  for (const Point& point : points) {
    std::memcpy(to, &point.position, 3 * sizeof(float));
    to[3 * sizeof(float)] = char(point.intensity);
    to[3 * sizeof(float) + 1] = char(point.geometry);
    to += kPointBytes;
  }
  std::ofstream file(path_, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\ncomment metres, y up\nelement vertex "
       << points.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar intensity\n"
          "property uchar geometry\nend_header\n";
  file.write(bytes.data(), std::streamsize(bytes.size()));
  file.close();
  if (file) return;
  std::error_code ignored;
  fs::remove(path_, ignored);
  throw OutputError(path_, "cannot be written");
}

}  // namespace lidar
