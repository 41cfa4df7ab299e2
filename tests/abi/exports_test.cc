// The drop-in exports what the real library exports, and nothing else.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "elf_file.h"

namespace dacrt::tests {
namespace {

TEST(Exports, AreTheRealLibrarys) {
  EXPECT_EQ(ReadElfFile(DACRT_DROP_IN).exports, ReadElfFile(DACRT_REAL_EMBREE).exports);
}

TEST(Exports, AreTheListedOnes) {
  std::ifstream file(DACRT_EXPORT_LIST);
  const std::set<std::string> listed{std::istream_iterator<std::string>(file), {}};
  EXPECT_EQ(listed.size(), 101u);
  EXPECT_EQ(ReadElfFile(DACRT_DROP_IN).exports, listed);
}

TEST(Exports, AreNamedInTheReadme) {
  std::ifstream file(DACRT_README);
  const std::string readme{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& name : ReadElfFile(DACRT_DROP_IN).exports) {
    EXPECT_NE(readme.find("`" + name + "`"), std::string::npos) << name;
  }
}

TEST(Exports, HaveNoVersions) { EXPECT_FALSE(ReadElfFile(DACRT_DROP_IN).has_versions); }

TEST(Soname, IsTheRealLibrarys) {
  EXPECT_EQ(ReadElfFile(DACRT_DROP_IN).soname, "libembree3.so.3");
  EXPECT_EQ(ReadElfFile(DACRT_REAL_EMBREE).soname, "libembree3.so.3");
}

}  // namespace
}  // namespace dacrt::tests
