#include "ambient_occlusion/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>

#include "ambient_occlusion/error.h"

namespace ao {
namespace {

bool IsFinite(const aiVector3D& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

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
    if (!std::all_of(face.mIndices, face.mIndices + 3, [&](unsigned index) {
          return index < source.mNumVertices && IsFinite(to_world * source.mVertices[index]);
        })) {
      continue;
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

}  // namespace

scenes::Mesh LoadMesh(const std::string& path) {
  const auto fail = [&](const std::string& what) {
    return Error(ExitCode::kMesh, path + ": " + what);
  };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw fail("there is no such file");
  if (!std::filesystem::is_regular_file(status)) throw fail("this is not a file");

  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (!scene) throw fail(std::string("cannot be loaded: ") + importer.GetErrorString());

  scenes::Mesh mesh;
  AppendNode(*scene, *scene->mRootNode, aiMatrix4x4(), &mesh);
  if (mesh.indices.empty()) throw fail("there is no triangle in it");
  return mesh;
}

}  // namespace ao
