#include "ply.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace dacrt::tests {
namespace {

static_assert(std::endian::native == std::endian::little);

struct Header {
  std::size_t vertex_count = 0;
  std::size_t face_count = 0;
};

Header ReadHeader(std::istream& file) {
  Header header;
  std::string properties;
  std::string format;
  std::string line;
  if (!std::getline(file, line) || line != "ply") throw std::runtime_error("not a PLY file");
  while (std::getline(file, line) && line != "end_header") {
    std::istringstream words(line);
    std::string keyword, name;
    words >> keyword;
    if (keyword == "format") {
      words >> format;
    } else if (keyword == "element") {
      words >> name;
      if (name == "vertex") {
        words >> header.vertex_count;
      } else if (name == "face") {
        words >> header.face_count;
      } else {
        throw std::runtime_error("unexpected element " + name);
      }
    } else if (keyword == "property") {
      properties += line.substr(std::strlen("property")) + ';';
    }
  }
  if (!file) throw std::runtime_error("header without end");
  if (format != "binary_little_endian") throw std::runtime_error("unexpected format " + format);
  if (properties != " float x; float y; float z; list uchar int vertex_indices;") {
    throw std::runtime_error("unexpected properties" + properties);
  }
  return header;
}

TestMesh ReadBody(std::istream& file, const Header& header) {
  constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(uint32_t);  // corner count, indices
  TestMesh mesh;
  mesh.positions.resize(header.vertex_count);
  mesh.triangles.resize(header.face_count);
  std::vector<char> faces(header.face_count * kFaceBytes);
  file.read(reinterpret_cast<char*>(mesh.positions.data()),
            static_cast<std::streamsize>(header.vertex_count * sizeof(Float3)));
  file.read(faces.data(), static_cast<std::streamsize>(faces.size()));
  if (!file) throw std::runtime_error("file ends early");
  for (std::size_t i = 0; i < header.face_count; ++i) {
    const char* const face = faces.data() + i * kFaceBytes;
    if (face[0] != 3) throw std::runtime_error("face that is no triangle");
    std::memcpy(mesh.triangles[i].vertex, face + 1, 3 * sizeof(uint32_t));
    for (const uint32_t index : mesh.triangles[i].vertex) {
      if (index >= header.vertex_count) throw std::runtime_error("index outside the vertices");
    }
  }
  return mesh;
}

}  // namespace

TestMesh ReadPly(const std::filesystem::path& path) {
  try {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error("cannot be opened");
    const Header header = ReadHeader(file);
    return ReadBody(file, header);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path.string() + ": " + error.what());
  }
}

}  // namespace dacrt::tests
