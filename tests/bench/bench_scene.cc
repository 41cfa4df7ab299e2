#include "bench_scene.h"

#include <algorithm>
#include <utility>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/mesh_file.h"
#include "automatic_view.h"
#include "errors.h"

namespace dacrt::bench {
namespace {

struct Hall {
  const char* name;
  uint32_t triangles;
};

constexpr Hall kHalls[] = {
    {"hall-75k", 75'000}, {"hall-260k", 260'000}, {"hall-1m", 1'000'000}, {"hall-5m", 5'000'000}};

// Under the vault, over the middle of the nave.
constexpr float kHallLampHeight = 6.5f;
const Lamp kHallLamp = {{-3, kHallLampHeight, 0.3f}, 0.8f};

struct KnownMesh {
  const char* name;
  BenchView view;
  Lamp lamp;
};

// Interiors are lit from within, some way below the ceiling and off their axis; the others from
// above and behind the camera.
const KnownMesh kKnownMeshes[] = {
    {"sibenik", {{-16, -11.5f, 0}, {0, -9.5f, 0}, 65}, {{-5, -3, 0.8f}, 0.8f}},
    {"sponza", {{-1000, 200, 0}, {500, 300, 50}, 70}, {{-250, 900, -60}, 90}},
    {"country_kitchen",
     {{1.211f, 1.8047f, 3.8524f}, {-0.1033f, 1.6797f, 1.1585f}, 36},
     {{0.3f, 2.5f, 1.2f}, 0.2f}},
    {"terrain_white_mountains",
     {{15600, 8000, 33000}, {15600, 800, 25000}, 45},
     {{9000, 12000, 30000}, 1000}},
    {"dragon", {{-0.08f, 0.16f, 0.12f}, {0.02f, 0.12f, 0}, 35}, {{-0.15f, 0.35f, 0.25f}, 0.03f}},
};

template <class Table>
auto* FindByName(const Table& table, const std::string& name) {
  const auto found = std::find_if(std::begin(table), std::end(table),
                                  [&](const auto& entry) { return name == entry.name; });
  return found == std::end(table) ? nullptr : &*found;
}

BenchScene MakeHallScene(const Hall& hall) {
  const scenes::Camera camera = scenes::HallCamera();
  return {hall.name,
          scenes::MakeHall(hall.triangles),
          {Imath::V3f(camera.eye), Imath::V3f(camera.look_at), camera.vertical_fov},
          kHallLamp};
}

scenes::Mesh LoadMesh(const std::string& path) {
  try {
    return ao::LoadMesh(path);
  } catch (const ao::Error& error) {
    throw UnreadableScene(error.what());
  }
}

}  // namespace

TriangleMesh BenchScene::AsTriangleMesh() const {
  return {.vertices = mesh.positions.data(),
          .vertex_count = mesh.VertexCount(),
          .triangles = mesh.indices.data(),
          .triangle_count = mesh.TriangleCount()};
}

Imath::Box3f Bounds(const scenes::Mesh& mesh) {
  Imath::Box3f bounds;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 3) {
    const float* const vertex = &mesh.positions[i];
    bounds.extendBy({vertex[0], vertex[1], vertex[2]});
  }
  return bounds;
}

SceneSource::SceneSource(std::string name, const std::filesystem::path& folder)
    : name_(std::move(name)) {
  if (FindByName(kHalls, name_)) return;
  file_ = name_;
  if (FindByName(kKnownMeshes, name_)) file_ = folder / (name_ + ".ply");
}

bool SceneSource::IsPresent() const { return file_.empty() || std::filesystem::exists(file_); }

BenchScene SceneSource::Load() const {
  if (const Hall* const hall = FindByName(kHalls, name_)) return MakeHallScene(*hall);
  if (!IsPresent()) {
    std::string message = file_.string() + ": there is no such file; the scenes with a name are";
    for (const std::string& name : SceneNames()) message += " " + name;
    throw UnreadableScene(message);
  }
  BenchScene scene{.name = name_, .mesh = LoadMesh(file_.string()), .view = {}, .lamp = {}};
  if (const KnownMesh* const known = FindByName(kKnownMeshes, name_)) {
    scene.view = known->view;
    scene.lamp = known->lamp;
  } else {
    scene.name = file_.stem().string();
    ChooseViewAndLamp(scene);
  }
  return scene;
}

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const Hall& hall : kHalls) names.push_back(hall.name);
  for (const KnownMesh& mesh : kKnownMeshes) names.push_back(mesh.name);
  return names;
}

}  // namespace dacrt::bench
