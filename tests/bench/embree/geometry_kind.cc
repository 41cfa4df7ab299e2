#include "geometry_kind.h"

#include <algorithm>
#include <iterator>

#include "mesh_cut.h"
#include "mesh_shapes.h"
#include "turn.h"
#include "wave.h"

namespace dacrt::bench {
namespace {

SceneContent Triangles(const BenchScene& scene) {
  SceneContent content;
  content.geometries.push_back(WholeMesh(scene.mesh));
  return content;
}

SceneContent Flagged(const BenchScene& scene, RTCSceneFlags flags) {
  SceneContent content = Triangles(scene);
  content.flags = flags;
  return content;
}

SceneContent Robust(const BenchScene& scene) { return Flagged(scene, RTC_SCENE_FLAG_ROBUST); }

SceneContent Compact(const BenchScene& scene) { return Flagged(scene, RTC_SCENE_FLAG_COMPACT); }

// Half of the parts are seen by half of the rays only.
SceneContent Masked(const BenchScene& scene) {
  constexpr std::size_t kParts = 8;
  SceneContent content;
  content.needs.masks = true;
  CutIntoParts(scene.mesh, kParts, content);
  for (std::size_t i = 0; i < content.geometries.size(); ++i) {
    content.geometries[i].mask = i % 2 ? 2 : 1;
  }
  return content;
}

SceneContent Filtered(const BenchScene& scene) {
  SceneContent content = Triangles(scene);
  content.geometries.front().is_filtered = true;
  return content;
}

// A sphere between the eye and what it looks at, of a fiftieth of the diagonal.
SceneContent WithUserGeometry(const BenchScene& scene) {
  constexpr float kRadius = 0.02f;
  SceneContent content = Triangles(scene);
  const Imath::V3f centre = (scene.view.eye + scene.view.look_at) / 2;
  const float radius = kRadius * Bounds(scene.mesh).size().length();
  content.floats.push_back({centre.x, centre.y, centre.z, radius});
  GeometryContent& sphere = content.geometries.emplace_back();
  sphere.type = RTC_GEOMETRY_TYPE_USER;
  sphere.user = content.floats.back().data();
  return content;
}

SceneContent Instances(const BenchScene& scene, std::size_t count) {
  SceneContent parts;
  CutIntoParts(scene.mesh, count, parts);
  // By so little that the view stays what it is.
  const Transform turned = TurnAbout(Bounds(scene.mesh).center(), 1);
  SceneContent content;
  content.floats = std::move(parts.floats);
  content.numbers = std::move(parts.numbers);
  for (GeometryContent& part : parts.geometries) {
    GeometryContent& instance = content.geometries.emplace_back();
    instance.type = RTC_GEOMETRY_TYPE_INSTANCE;
    instance.scene = content.instanced.size();
    instance.transform = turned;
    content.instanced.emplace_back().geometries.push_back(std::move(part));
  }
  return content;
}

SceneContent Instance(const BenchScene& scene) { return Instances(scene, 1); }

SceneContent ThousandInstances(const BenchScene& scene) { return Instances(scene, 1000); }

SceneContent Moving(const BenchScene& scene) {
  SceneContent content = Triangles(scene);
  content.needs.times = true;
  content.floats.push_back(scene.mesh.positions);
  Wave(scene.mesh).Apply(0.25f, 0, content.floats.back());
  content.geometries.front().vertices.push_back(content.floats.back().data());
  return content;
}

SceneContent Parts(const BenchScene& scene, std::size_t count) {
  SceneContent content;
  CutIntoParts(scene.mesh, count, content);
  return content;
}

SceneContent FewParts(const BenchScene& scene) { return Parts(scene, 200); }

SceneContent ManyParts(const BenchScene& scene) { return Parts(scene, 10'000); }

constexpr GeometryKind kKinds[] = {
    {"triangles", Triangles},
    {"robust", Robust},
    {"compact", Compact},
    {"quads", Quads},
    {"grids", Grids},
    {"spheres", Spheres},
    {"masked", Masked},
    {"filter", Filtered},
    {"user", WithUserGeometry},
    {"instance", Instance},
    {"instances-1000", ThousandInstances},
    {"moving", Moving},
    {"parts-200", FewParts},
    {"parts-10000", ManyParts},
};

}  // namespace

std::span<const GeometryKind> GeometryKinds() { return kKinds; }

const GeometryKind* FindGeometryKind(const std::string& name) {
  const auto found = std::ranges::find(kKinds, name, &GeometryKind::name);
  return found == std::end(kKinds) ? nullptr : found;
}

}  // namespace dacrt::bench
