// The scenes of the tests: generated ones, and meshes of a folder where it is there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "vec3.h"

namespace dacrt::tests {

struct Triangle {
  uint32_t vertex[3];
};

/// How a mesh lies in the buffers that a library is given; in bytes, multiples of four.
struct BufferLayout {
  std::size_t vertex_offset = 0;
  std::size_t vertex_stride = 12;
  std::size_t index_offset = 0;
  std::size_t index_stride = 12;
};

struct TestMesh {
  std::vector<Float3> positions;
  std::vector<Triangle> triangles;
  uint32_t geometry_id = 0;
  uint32_t mask = UINT32_MAX;
  bool enabled = true;
  BufferLayout layout;
};

/// A view from which the scene is worth looking at. Up is y; the picture is square.
struct Camera {
  Float3 eye;
  Float3 target;
  float vertical_fov_degrees = 60;
};

struct TestScene {
  std::string name;
  std::vector<TestMesh> meshes;
  std::vector<Camera> cameras;  ///< none: any view of the bounds will do

  std::size_t TriangleCount() const;

  /// Corners of the bounds of all vertices; both the origin if there are none.
  struct Corners {
    Float3 lower, upper;
  };
  Corners Bounds() const;
};

/// A scene that is made when it is asked for.
struct SceneSource {
  std::string name;
  std::function<TestScene()> make;
};

/// Scenes that need nothing but this code.
std::vector<SceneSource> GeneratedScenes();

/// One scene for each known mesh that is found in `folder`; none if there is no such folder.
std::vector<SceneSource> MeshScenes(const std::filesystem::path& folder);

}  // namespace dacrt::tests
