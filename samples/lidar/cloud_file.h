// Writing the points.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "lidar/scanner.h"

namespace lidar {

// A point cloud to be written: PLY, binary, of x, y, z, intensity and geometry.
class CloudFile {
 public:
  // Throws ao::Error with kOutput if it could not be written there.
  explicit CloudFile(const std::string& path);

  // Throws ao::Error with kOutput, and leaves nothing behind then.
  void Write(std::span<const Point> points) const;

 private:
  std::filesystem::path path_;
};

}  // namespace lidar
