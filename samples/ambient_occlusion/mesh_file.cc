#include "ambient_occlusion/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <unistd.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <exception>
#include <filesystem>
#include <limits>
#include <new>
#include <system_error>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/isolated.h"
#include "ambient_occlusion/ply_check.h"

namespace ao {
namespace {

void AppendMesh(const aiMesh& source, const aiMatrix4x4& to_world, scenes::Mesh* mesh) {
  const size_t first = mesh->VertexCount();
  if (first + source.mNumVertices > std::numeric_limits<uint32_t>::max()) {
    throw Error(ExitCode::kMesh, "the mesh has more vertices than 32 bits can number");
  }
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D p = to_world * source.mVertices[i];
    mesh->positions.insert(mesh->positions.end(), {p.x, p.y, p.z});
  }
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    if (face.mNumIndices != 3) continue;  // a point or a line
    if (!std::all_of(face.mIndices, face.mIndices + 3,
                     [&](unsigned index) { return index < source.mNumVertices; })) {
      throw Error(ExitCode::kMesh, "a triangle names a vertex that is not there");
    }
    for (int corner = 0; corner < 3; ++corner) {
      mesh->indices.push_back(uint32_t(first + face.mIndices[corner]));
    }
  }
}

void AppendNode(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent_to_world,
                scenes::Mesh* mesh) {
  const aiMatrix4x4 to_world = parent_to_world * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    AppendMesh(*scene.mMeshes[node.mMeshes[i]], to_world, mesh);
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    AppendNode(scene, *node.mChildren[i], to_world, mesh);
  }
}

void CheckIsFile(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw Error(ExitCode::kMesh, "there is no such file");
  if (std::filesystem::is_directory(status)) throw Error(ExitCode::kMesh, "this is a folder");
  if (access(path.c_str(), R_OK) != 0) throw Error(ExitCode::kMesh, "the file cannot be read");
}

std::string LowerCaseExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return extension;
}

scenes::Mesh Import(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (!scene) {
    if (importer.GetException()) {
      try {
        std::rethrow_exception(importer.GetException());
      } catch (const std::bad_alloc&) {
        throw;
      } catch (...) {
        // The message below says it.
      }
    }
    throw Error(ExitCode::kMesh, std::string("cannot be loaded: ") + importer.GetErrorString());
  }
  scenes::Mesh mesh;
  AppendNode(*scene, *scene->mRootNode, aiMatrix4x4(), &mesh);
  if (mesh.indices.empty()) throw Error(ExitCode::kMesh, "there is no triangle in it");
  return mesh;
}

}  // namespace

scenes::Mesh LoadMesh(const std::string& path) {
  try {
    CheckIsFile(path);
    if (LowerCaseExtension(path) == ".ply") CheckPlyIsComplete(path);
    // Assimp crashes on some broken files.
    return LoadIsolated([&] { return Import(path); });
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace ao
