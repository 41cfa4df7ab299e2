// The scenes that are measured on: a mesh, a view of it, and a lamp.
#pragma once

#include <Imath/ImathBox.h>
#include <Imath/ImathVec.h>

#include <filesystem>
#include <string>
#include <vector>

#include "dacrt/dacrt.h"
#include "scenes/hall.h"

namespace dacrt::bench {

struct BenchView {
  Imath::V3f eye;
  Imath::V3f look_at;
  float vertical_fov;  ///< degrees; the picture is square, and up is y
};

/// A point light at the centre, or a level square panel about it that shines from both faces.
struct Lamp {
  Imath::V3f centre;
  float half_size;  ///< of the panel's side
};

struct BenchScene {
  std::string name;
  scenes::Mesh mesh;
  BenchView view;
  Lamp lamp;

  std::size_t TriangleCount() const { return mesh.TriangleCount(); }

  /// The mesh where it lies, as dacrt takes it. The scene must stay where it is.
  TriangleMesh AsTriangleMesh() const;
};

/// The bounds of all vertices.
Imath::Box3f Bounds(const scenes::Mesh& mesh);

/// Where a scene comes from: a name of SceneNames, "hall-" with a number of triangles such as 300k
/// or 2m, or else the path of a mesh.
class SceneSource {
 public:
  SceneSource(std::string name, const std::filesystem::path& folder);

  const std::string& name() const { return name_; }

  bool IsGenerated() const { return file_.empty(); }

  /// False only for a mesh that is not there.
  bool IsPresent() const;

  /// Throws UnreadableScene (errors.h).
  BenchScene Load() const;

  /// The same, with a float behind the last vertex, which Embree reads.
  BenchScene LoadForEmbree() const;

 private:
  std::string name_;
  std::filesystem::path file_;  ///< empty for a generated scene
};

/// The scenes that the benchmarks are about, the generated ones first.
std::vector<std::string> SceneNames();

/// Those of the names that are generated or in the folder.
std::vector<std::string> PresentScenes(std::vector<std::string> names,
                                       const std::filesystem::path& folder);

/// All others that have a name: a box of 36 triangles, smaller meshes, other views.
std::vector<std::string> MoreSceneNames();

}  // namespace dacrt::bench
