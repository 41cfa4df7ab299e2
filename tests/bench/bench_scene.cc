#include "bench_scene.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "ambient_occlusion/error.h"
#include "ambient_occlusion/mesh_file.h"
#include "automatic_view.h"
#include "box_scene.h"
#include "errors.h"

namespace dacrt::bench {
namespace {

constexpr const char* kHalls[] = {"hall-75k", "hall-260k", "hall-1m", "hall-5m"};
constexpr char kBox[] = "box-36";

// Under the vault, over the middle of the nave.
constexpr float kHallLampHeight = 6.5f;
const Lamp kHallLamp = {{-3, kHallLampHeight, 0.3f}, 0.8f};

struct KnownMesh {
  const char* name;
  const char* file;
  BenchView view;
  Lamp lamp;
};

const Lamp kSibenikLamp = {{-5, -3, 0.8f}, 0.8f};
const Lamp kSponzaLamp = {{-250, 900, -60}, 90};
const Lamp kKitchenLamp = {{0.3f, 2.5f, 1.2f}, 0.2f};
const Lamp kTerrainLamp = {{9000, 12000, 30000}, 1000};
const Lamp kCornellLamp = {{0, 1.55f, 0}, 0.2f};
const Lamp kDragonLamp = {{-0.15f, 0.35f, 0.25f}, 0.03f};
const BenchView kDragonView = {{-0.08f, 0.16f, 0.12f}, {0.02f, 0.12f, 0}, 35};

// Interiors are lit from within, some way below the ceiling and off their axis; the others from
// above and behind the camera.
const KnownMesh kKnownMeshes[] = {
    {"sibenik", "sibenik", {{-16, -11.5f, 0}, {0, -9.5f, 0}, 65}, kSibenikLamp},
    {"sponza", "sponza", {{-1000, 200, 0}, {500, 300, 50}, 70}, kSponzaLamp},
    {"country_kitchen",
     "country_kitchen",
     {{1.211f, 1.8047f, 3.8524f}, {-0.1033f, 1.6797f, 1.1585f}, 36},
     kKitchenLamp},
    {"terrain_white_mountains",
     "terrain_white_mountains",
     {{15600, 8000, 33000}, {15600, 800, 25000}, 45},
     kTerrainLamp},
    {"dragon", "dragon", kDragonView, kDragonLamp},
};
const KnownMesh kMoreMeshes[] = {
    {"cornell_water", "cornell_water", {{0, 0.8f, 2.6f}, {0, 0.8f, 0}, 40}, kCornellLamp},
    {"bunny", "bunny", {{-0.02f, 0.13f, 0.2f}, {-0.02f, 0.105f, 0}, 45}, kDragonLamp},
    {"dragon_res2", "dragon_res2", kDragonView, kDragonLamp},
    {"dragon_res3", "dragon_res3", kDragonView, kDragonLamp},
    {"dragon_res4", "dragon_res4", kDragonView, kDragonLamp},
    // Other views of the same.
    {"sibenik-choir", "sibenik", {{12, -12, -2}, {-10, -9, 2}, 65}, kSibenikLamp},
    {"sponza-gallery", "sponza", {{1100, 650, -350}, {-300, 200, 100}, 70}, kSponzaLamp},
    {"country_kitchen-table",
     "country_kitchen",
     {{1.2f, 1.6f, 3.2f}, {0.2f, 1.1f, -1}, 60},
     kKitchenLamp},
    {"terrain_white_mountains-range",
     "terrain_white_mountains",
     {{18000, 2600, 16000}, {15600, 600, 25480}, 45},
     kTerrainLamp},
    {"dragon-whole", "dragon", {{0, 0.14f, 0.35f}, {-0.01f, 0.12f, 0}, 40}, kDragonLamp},
};

// The triangles of "hall-300k", "hall-2m" or "hall-123456"; nothing if it is no such name.
std::optional<std::uint32_t> HallTriangles(const std::string& name) {
  constexpr std::string_view kPrefix = "hall-";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  double triangles = 0;
  const char* const end = name.data() + name.size();
  const auto [unit, error] = std::from_chars(name.data() + kPrefix.size(), end, triangles);
  if (error != std::errc()) return std::nullopt;
  const std::string_view suffix(unit, end);
  if (suffix == "k") triangles *= 1e3;
  if (suffix == "m") triangles *= 1e6;
  const bool is_legal = suffix.empty() || suffix == "k" || suffix == "m";
  if (!is_legal || triangles < 1 || triangles > scenes::kHallMostTriangles) return std::nullopt;
  return static_cast<std::uint32_t>(triangles);
}

const KnownMesh* FindKnown(const std::string& name) {
  for (const std::span<const KnownMesh> meshes :
       {std::span<const KnownMesh>(kKnownMeshes), std::span<const KnownMesh>(kMoreMeshes)}) {
    for (const KnownMesh& mesh : meshes) {
      if (name == mesh.name) return &mesh;
    }
  }
  return nullptr;
}

BenchScene MakeHallScene(const std::string& name, std::uint32_t triangles) {
  const scenes::Camera camera = scenes::HallCamera();
  return {name,
          scenes::MakeHall(triangles),
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
  for (std::size_t i = 0; i < 3 * mesh.VertexCount(); i += 3) {  // there may be floats behind
    const float* const vertex = &mesh.positions[i];
    bounds.extendBy({vertex[0], vertex[1], vertex[2]});
  }
  return bounds;
}

SceneSource::SceneSource(std::string name, const std::filesystem::path& folder)
    : name_(std::move(name)) {
  if (name_ == kBox || HallTriangles(name_)) return;
  const KnownMesh* const known = FindKnown(name_);
  file_ = known ? folder / (std::string(known->file) + ".ply") : std::filesystem::path(name_);
}

bool SceneSource::IsPresent() const { return IsGenerated() || std::filesystem::exists(file_); }

BenchScene SceneSource::Load() const {
  if (name_ == kBox) return MakeBox();
  if (const auto triangles = HallTriangles(name_)) return MakeHallScene(name_, *triangles);
  if (!IsPresent()) {
    std::string message = file_.string() + ": there is no such file; the scenes with a name are";
    for (const std::string& name : SceneNames()) message += " " + name;
    for (const std::string& name : MoreSceneNames()) message += " " + name;
    throw UnreadableScene(message);
  }
  BenchScene scene{.name = name_, .mesh = LoadMesh(file_.string()), .view = {}, .lamp = {}};
  if (const KnownMesh* const known = FindKnown(name_)) {
    scene.view = known->view;
    scene.lamp = known->lamp;
  } else {
    scene.name = file_.stem().string();
    ChooseViewAndLamp(scene);
  }
  return scene;
}

BenchScene SceneSource::LoadForEmbree() const {
  BenchScene scene = Load();
  scene.mesh.positions.push_back(0);
  return scene;
}

std::vector<std::string> SceneNames() {
  std::vector<std::string> names(std::begin(kHalls), std::end(kHalls));
  for (const KnownMesh& mesh : kKnownMeshes) names.push_back(mesh.name);
  return names;
}

std::vector<std::string> PresentScenes(std::vector<std::string> names,
                                       const std::filesystem::path& folder) {
  std::erase_if(names,
                [&](const std::string& name) { return !SceneSource(name, folder).IsPresent(); });
  return names;
}

std::vector<std::string> MoreSceneNames() {
  std::vector<std::string> names = {kBox};
  for (const KnownMesh& mesh : kMoreMeshes) names.push_back(mesh.name);
  return names;
}

}  // namespace dacrt::bench
