// Files that are written whole or not at all.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace dacrt::bench {

class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes `text` beside `path` and moves it there, so that `path` is never half written.
/// Throws OutputError that names the file.
void WriteFile(const std::filesystem::path& path, const std::string& text);

/// Throws OutputError that names the folder, unless it is or can be made.
void MakeFolder(const std::filesystem::path& path);

}  // namespace dacrt::bench
