// What the dynamic linker sees of a shared library.
#pragma once

#include <set>
#include <string>

namespace dacrt::tests {

struct ElfFile {
  std::string soname;
  std::set<std::string> exports;  ///< names that the library defines for others
  bool has_versions = false;      ///< whether these names carry symbol versions
};

/// Throws std::runtime_error unless `path` is a 64-bit shared library.
ElfFile ReadElfFile(const std::string& path);

}  // namespace dacrt::tests
