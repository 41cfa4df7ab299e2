// Scenes from files. The cameras were chosen by looking at what they show.
#include <utility>

#include "ply.h"
#include "scenes.h"

namespace dacrt::tests {
namespace {

struct MeshFile {
  const char* name;
  std::vector<Camera> cameras;
};

const std::vector<Camera> kDragonViews = {{{0, 0.14f, 0.35f}, {-0.01f, 0.12f, 0}, 40},
                                          {{-0.08f, 0.16f, 0.12f}, {0.02f, 0.12f, 0}, 35}};

const std::vector<MeshFile> kMeshFiles = {
    {"cornell_water",
     {{{0, 0.8f, 2.6f}, {0, 0.8f, 0}, 40}, {{0, 0.9f, 0.9f}, {0, 0.6f, -0.6f}, 50}}},
    {"dragon_res4", kDragonViews},
    {"dragon_res3", kDragonViews},
    {"bunny",
     {{{0, 0.15f, 0.35f}, {-0.02f, 0.11f, 0}, 40},
      {{-0.02f, 0.13f, 0.2f}, {-0.02f, 0.105f, 0}, 45}}},
    {"sibenik",
     {{{-16, -11.5f, 0}, {0, -9.5f, 0}, 65},
      {{-17, -11, 0}, {10, -8, 0}, 70},
      {{12, -12, -2}, {-10, -9, 2}, 65},
      {{12, -10, 0.5f}, {-5, -8, -0.5f}, 70}}},
    {"dragon_res2", kDragonViews},
    {"sponza",
     {{{-1000, 200, 0}, {500, 300, 50}, 70},
      {{-1100, 180, -40}, {0, 300, -40}, 60},
      {{1100, 650, -350}, {-300, 200, 100}, 70},
      {{1150, 620, -440}, {-600, 420, -20}, 65}}},
    {"dragon", kDragonViews},
    {"country_kitchen",
     {{{1.211f, 1.8047f, 3.8524f}, {-0.1033f, 1.6797f, 1.1585f}, 36},
      {{1.2f, 1.6f, 3.2f}, {0.2f, 1.1f, -1}, 60},
      {{-1.5f, 1.7f, 3.5f}, {1, 1.2f, 0}, 60}}},
    {"terrain_white_mountains",
     {{{15600, 8000, 33000}, {15600, 800, 25000}, 45},
      {{18000, 2600, 16000}, {15600, 600, 25480}, 45}}},
};

}  // namespace

std::vector<SceneSource> MeshScenes(const std::filesystem::path& folder) {
  std::vector<SceneSource> sources;
  for (const MeshFile& file : kMeshFiles) {
    const std::filesystem::path path = folder / (std::string(file.name) + ".ply");
    if (!std::filesystem::exists(path)) continue;
    sources.push_back({file.name, [&file, path] {
                         TestScene scene{file.name, {}, file.cameras};
                         scene.meshes.push_back(ReadPly(path));
                         return scene;
                       }});
  }
  return sources;
}

}  // namespace dacrt::tests
