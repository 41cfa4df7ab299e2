// Packets of up to eight rays in small scenes, which go as handfuls where they can: they find what
// each ray finds alone, to the last bit.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "kept_trace.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::FullRay;
using unit::GeometryOf;
using unit::Mesh;

class HandfulTest : public unit::OnEachInstructionSet {
 protected:
  /// Triangles of up to a fifth of the scene, of which some coincide.
  Mesh Soup(uint32_t id, uint32_t mask) {
    Mesh mesh = unit::MakeSoup(random_, 20, 2, 0.8f);
    for (std::size_t i = 0; i < 20; i += 6) mesh.triangles.push_back(mesh.triangles[i]);
    mesh.geometry_id = id;
    mesh.mask = mask;
    return mesh;
  }

  /// Those that look at what stands about the middle, with every mask, at every time, some up to
  /// where they hit something or right before.
  std::vector<FullRay> Rays(const Scene& scene) {
    std::vector<FullRay> rays;
    for (int i = 0; i < 400; ++i) {
      unit::Ray ray = unit::MakeRay(random_.InCube(-3, 3), random_.Direction());
      if (i % 3 == 0) ray.tnear = random_.Uniform(-0.5f, 1);
      ray.mask = 1 + static_cast<uint32_t>(random_.Below(7));
      rays.push_back(unit::FullRayOf(ray, random_.Uniform(-0.1f, 1.1f)));
    }
    const auto hits = unit::TracePackets(scene, rays, Query::kClosest, 1, nullptr);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!hits[i].IsHit() || i % 5 >= 2) continue;
      const float t = hits[i].Get(PacketComponent::kTfar);
      rays[i].Set(PacketComponent::kTfar, i % 5 == 0 ? t : std::nextafter(t, 0.0f));
    }
    return rays;
  }

  unit::Random random_{31};
};
INSTANTIATE_ON_EACH_INSTRUCTION_SET(HandfulTest);

Geometry InstanceOf(const std::shared_ptr<const Scene>& scene, uint32_t id, uint32_t mask,
                    float x) {
  Geometry geometry;
  geometry.shape = Shape::kInstance;
  geometry.geometry_id = id;
  geometry.mask = mask;
  geometry.primitive_count = 1;
  geometry.instanced_scene = scene;
  geometry.transforms.resize(1);
  auto& column = geometry.transforms[0].matrix.column;
  column[0][0] = column[1][1] = column[2][2] = 0.6f;
  column[0][1] = 0.3f;
  column[3][0] = x;
  return geometry;
}

TEST_P(HandfulTest, AsEachRayAlone) {
  for (int kind = 0; kind < 16; ++kind) {
    const bool robust = kind & 1, moves = kind & 2, instances = kind & 4, masked = kind & 8;
    SCOPED_TRACE("kind " + std::to_string(kind));
    const auto device = std::make_shared<Device>(WithInstructionSet({}));
    const SceneOptions options{.robust = robust};
    const auto mask = [&](uint32_t some) { return masked ? some : UINT32_MAX; };
    const Mesh first = Soup(3, mask(1)), second = Soup(7, mask(2)), shown = Soup(0, mask(6));
    std::vector<Float3> moved = first.vertices;
    for (Float3& vertex : moved) vertex[1] += 0.3f;
    std::vector<Geometry> geometries = {GeometryOf(first), GeometryOf(second)};
    if (moves) geometries[0].vertices.push_back({moved.data(), sizeof(Float3)});
    if (instances) {
      const auto scene = std::make_shared<Scene>(device, GeometryOf(shown), options);
      // Two in one place: names decide.
      geometries.push_back(InstanceOf(scene, 5, mask(4), 1));
      geometries.push_back(InstanceOf(scene, 2, mask(3), 1));
      geometries.push_back(InstanceOf(scene, 9, mask(2), -1));
    }
    const Scene scene(device, geometries, options);
    const std::vector<FullRay> rays = Rays(scene);
    for (const Query query : {Query::kClosest, Query::kAny}) {
      const auto alone = unit::TracePackets(scene, rays, query, 1, nullptr);
      for (const uint32_t lanes : {2u, 4u, 5u, 8u}) {
        unit::ExpectSame(unit::TracePackets(scene, rays, query, lanes, nullptr), alone,
                         "packets of " + std::to_string(lanes));
      }
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace dacrt
