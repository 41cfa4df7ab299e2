// Draws a mesh lit by ambient occlusion: the steps, in order.
#include <utility>

#include "ambient_occlusion/embree_scene.h"
#include "ambient_occlusion/error.h"
#include "ambient_occlusion/image_file.h"
#include "ambient_occlusion/mesh_file.h"
#include "ambient_occlusion/options.h"
#include "ambient_occlusion/program.h"
#include "ambient_occlusion/progress.h"
#include "ambient_occlusion/render.h"
#include "ambient_occlusion/report.h"
#include "ambient_occlusion/stopwatch.h"
#include "ambient_occlusion/view.h"

namespace ao {
namespace {

scenes::Mesh GetMesh(const Options& options) {
  const Progress progress("mesh");
  return options.mesh.empty() ? scenes::MakeHall(options.hall_triangles) : LoadMesh(options.mesh);
}

double TimeCommit(Scene& scene) {
  const Progress progress("commit");
  const Stopwatch stopwatch;
  scene.Commit();
  return stopwatch.Seconds();
}

void Run(const Options& options) {
  const ImageFile file(options.output);
  scenes::Mesh mesh = GetMesh(options);
  const uint64_t triangles = mesh.TriangleCount();
  const Device device(options.device);
  Scene scene(device, std::move(mesh));
  const double commit_seconds = TimeCommit(scene);
  const Imath::Box3f bounds = scene.Bounds();
  if (bounds.isEmpty() || bounds.size().length() == 0) {
    throw Error(ExitCode::kMesh, options.mesh + ": the mesh has no extent");
  }
  const Camera camera(ChooseView(options, scene), options.width, options.height);
  const Rendering rendering = Render(options, scene, camera);
  file.Write(rendering.image);
  Print({.mesh = options.mesh.empty() ? "hall" : options.mesh,
         .triangles = triangles,
         .commit_seconds = commit_seconds,
         .closest_hit = rendering.closest_hit,
         .occlusion = rendering.occlusion,
         .picture = options.output});
}

}  // namespace
}  // namespace ao

int main(int argc, char** argv) {
  return ao::RunProgram("ambient_occlusion", [&] {
    if (const auto options = ao::ParseOptions(argc, argv)) ao::Run(*options);
  });
}
