// One small mesh, written in every format that the sample reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sample_test {

// An octahedron over a square. The square is one polygon where the format has polygons.
struct MeshFile {
  std::string name;
  std::string content;
};

std::vector<MeshFile> MeshInEveryFormat();
std::string MeshAs(const std::string& name);  // one of them

}  // namespace sample_test
