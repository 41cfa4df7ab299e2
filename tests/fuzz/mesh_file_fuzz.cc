// Files of any bytes for the samples' loader: a mesh whose indices are there, or an error that says
// what is wrong. Assimp reads in a process of its own, so what it makes of them is not looked at,
// but that it comes back is.
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/mesh_file.h"
#include "input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, std::size_t count) {
  dacrt::fuzz::Input input(bytes, count);
  static constexpr const char* kTypes[] = {".ply", ".obj", ".stl", ".gltf"};
  const std::string path = "/dev/shm/dacrt_fuzz_" + std::to_string(getpid()) + input.OneOf(kTypes);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(input.rest()),
             static_cast<std::streamsize>(input.left()));
  try {
    const scenes::Mesh mesh = ao::LoadMesh(path);
    for (const uint32_t index : mesh.indices) {
      if (index >= mesh.VertexCount()) std::abort();
    }
  } catch (const ao::Error& error) {
    if (std::string(error.what()).find(path) == std::string::npos) std::abort();
  }
  unlink(path.c_str());
  return 0;
}
