#include "tests/meshes.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <stdexcept>

namespace sample_test {
namespace {

// All coordinates are exact in text and in binary.
constexpr std::array<std::array<float, 3>, 10> kVertices = {{{1, 0.5f, 0},
                                                             {-1, 0.5f, 0},
                                                             {0, 1.5f, 0},
                                                             {0, -0.5f, 0},
                                                             {0, 0.5f, 1},
                                                             {0, 0.5f, -1},
                                                             {-2, -0.75f, -2},
                                                             {-2, -0.75f, 2},
                                                             {2, -0.75f, 2},
                                                             {2, -0.75f, -2}}};
constexpr std::array<std::array<uint16_t, 3>, 10> kTriangles = {{{0, 2, 4},
                                                                 {2, 1, 4},
                                                                 {1, 3, 4},
                                                                 {3, 0, 4},
                                                                 {2, 0, 5},
                                                                 {1, 2, 5},
                                                                 {3, 1, 5},
                                                                 {0, 3, 5},
                                                                 {6, 7, 8},
                                                                 {6, 8, 9}}};
constexpr size_t kOctahedron = 8;  // the triangles before those of the square

template <class T>
std::string Bytes(const T& value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}

std::string Obj() {
  std::ostringstream text;
  text << "# an octahedron over a square\n";
  for (const auto& v : kVertices) text << "v " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
  for (size_t i = 0; i < kOctahedron; ++i) {
    const auto& t = kTriangles[i];
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
  text << "f 7 8 9 10\nl 1 2\n";
  return text.str();
}

std::string Ply(bool binary) {
  std::ostringstream file;
  file << "ply\nformat " << (binary ? "binary_little_endian" : "ascii") << " 1.0\n"
       << "element vertex " << kVertices.size() << '\n'
       << "property float x\nproperty float y\nproperty float z\n"
       << "element face " << kOctahedron + 1 << '\n'
       << "property list uchar int vertex_indices\nend_header\n";
  for (const auto& v : kVertices) {
    if (binary) {
      file << Bytes(v);
    } else {
      file << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
    }
  }
  const auto write_face = [&](const std::vector<int32_t>& corners) {
    file << (binary ? std::string(1, char(corners.size())) : std::to_string(corners.size()));
    for (int32_t corner : corners) file << (binary ? Bytes(corner) : ' ' + std::to_string(corner));
    if (!binary) file << '\n';
  };
  for (size_t i = 0; i < kOctahedron; ++i) {
    write_face({kTriangles[i].begin(), kTriangles[i].end()});
  }
  write_face({6, 7, 8, 9});
  return file.str();
}

std::string Stl(bool binary) {
  std::ostringstream file;
  if (binary) {
    file << std::string(80, '\0') << Bytes(uint32_t(kTriangles.size()));
  } else {
    file << "solid octahedron\n";
  }
  for (const auto& triangle : kTriangles) {
    file << (binary ? std::string(12, '\0') : "facet normal 0 0 0\nouter loop\n");
    for (uint16_t corner : triangle) {
      const auto& v = kVertices[corner];
      if (binary) {
        file << Bytes(v);
      } else {
        file << "vertex " << v[0] << ' ' << v[1] << ' ' << v[2] << '\n';
      }
    }
    file << (binary ? std::string(2, '\0') : "endloop\nendfacet\n");
  }
  if (!binary) file << "endsolid octahedron\n";
  return file.str();
}

// The octahedron sits in a node that lifts it by a half, under another that turns nothing; the
// square, in a node that lowers it.
std::string GltfBuffer() {
  std::string buffer;
  for (size_t i = 0; i < kVertices.size(); ++i) {
    auto v = kVertices[i];
    v[1] += i < 6 ? -0.5f : 0.75f;
    buffer += Bytes(v);
  }
  for (const auto& triangle : kTriangles) buffer += Bytes(triangle);
  return buffer;
}

std::string GltfJson(const std::string& buffer_members) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,2]}],
"nodes":[{"children":[1],"translation":[0,0.25,0]},{"mesh":0,"translation":[0,0.25,0]},
{"mesh":1,"translation":[0,-0.75,0]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]},
{"primitives":[{"attributes":{"POSITION":0},"indices":2}]}],
"buffers":[{)" +
         buffer_members +
         R"("byteLength":180}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":120},{"buffer":0,"byteOffset":120,"byteLength":60}],
"accessors":[{"bufferView":0,"componentType":5126,"count":10,"type":"VEC3","min":[-2,0,-2],"max":[2,1,2]},
{"bufferView":1,"componentType":5123,"count":24,"type":"SCALAR"},
{"bufferView":1,"byteOffset":48,"componentType":5123,"count":6,"type":"SCALAR"}]})";
}

std::string Base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {  // the buffer's size is a multiple of three
    const uint32_t three =
        uint8_t(bytes[i]) << 16 | uint8_t(bytes[i + 1]) << 8 | uint8_t(bytes[i + 2]);
    for (int shift : {18, 12, 6, 0}) text += kDigits[three >> shift & 63];
  }
  return text;
}

std::string Gltf() {
  return GltfJson("\"uri\":\"data:application/octet-stream;base64," + Base64(GltfBuffer()) + "\",");
}

std::string Glb() {
  std::string json = GltfJson("");
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string buffer = GltfBuffer();
  const auto size = [](const std::string& chunk) { return Bytes(uint32_t(chunk.size())); };
  const std::string chunks =
      size(json) + "JSON" + json + size(buffer) + std::string("BIN\0", 4) + buffer;
  return "glTF" + Bytes(uint32_t(2)) + Bytes(uint32_t(12 + chunks.size())) + chunks;
}

}  // namespace

std::vector<MeshFile> MeshInEveryFormat() {
  return {{"mesh.obj", Obj()},       {"binary.ply", Ply(true)}, {"ascii.ply", Ply(false)},
          {"binary.stl", Stl(true)}, {"ascii.stl", Stl(false)}, {"mesh.gltf", Gltf()},
          {"mesh.glb", Glb()}};
}

std::string MeshAs(const std::string& name) {
  for (const MeshFile& file : MeshInEveryFormat()) {
    if (file.name == name) return file.content;
  }
  throw std::invalid_argument(name);
}

}  // namespace sample_test
