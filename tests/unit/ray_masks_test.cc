// Rays that their masks let through some geometries only, by every way into a scene, meet what they
// meet in a scene of these geometries alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "kept_trace.h"

namespace dacrt::unit {
namespace {

class RayMasksTest : public KeptTraceTest {
 protected:
  /// Geometries one beside the other, whose leaves are of one geometry, and two among each other.
  RayMasksTest() {
    for (uint32_t id = 0; id < 6; ++id) {
      Mesh mesh = MakeSoup(random_, 400, id < 4 ? 0.4f : 1, 0.15f);
      for (Float3& vertex : mesh.vertices) {
        if (id < 4) vertex[id / 2] += id % 2 ? 0.5f : -0.5f;
      }
      mesh.geometry_id = id;
      mesh.mask = 1u << (id % 3);
      meshes_.push_back(mesh);
    }
  }

  std::unique_ptr<Scene> MakeScene(const std::vector<Mesh>& meshes, bool robust,
                                   Keep keep = Keep::kByBudget) const {
    std::vector<Geometry> geometries;
    for (const Mesh& mesh : meshes) geometries.push_back(GeometryOf(mesh));
    return std::make_unique<Scene>(std::make_shared<Device>(WithBudget(kDefaultBudget)), geometries,
                                   SceneOptions{.keep = keep, .robust = robust});
  }

  std::vector<FullRay> MakeRays(bool run_together, std::size_t count) {
    std::vector<FullRay> rays;
    for (std::size_t i = 0; i < count; ++i) {
      const auto narrow = [&] { return random_.Uniform(-0.2f, 0.2f); };
      Ray ray = run_together ? MakeRay({0.1f, 0.2f, -4}, {narrow(), narrow(), 1})
                             : MakeRay(random_.InCube(-1, 1), random_.Direction());
      ray.mask = random_.Below(8);
      rays.push_back(FullRayOf(ray));
    }
    return rays;
  }

  /// Each ray in a scene of the geometries that its mask lets it meet, where all have one that
  /// accepts all rays.
  std::vector<FullRay> Expected(const std::vector<FullRay>& rays, Query query, bool robust) const {
    std::vector<FullRay> expected = rays;
    for (uint32_t mask = 0; mask < 8; ++mask) {
      std::vector<Mesh> met;
      std::copy_if(meshes_.begin(), meshes_.end(), std::back_inserter(met),
                   [&](const Mesh& mesh) { return (mesh.mask & mask) != 0; });
      for (Mesh& mesh : met) mesh.mask = UINT32_MAX;
      const auto scene = MakeScene(met, robust);
      for (FullRay& ray : expected) {
        if (ray.Get<uint32_t>(PacketComponent::kMask) != mask) continue;
        ray.Set(PacketComponent::kMask, UINT32_MAX);
        ray = TraceForm(*scene, {ray}, query).front();
        ray.Set(PacketComponent::kMask, mask);
      }
    }
    return expected;
  }

  Random random_{5};
  std::vector<Mesh> meshes_;
};

TEST_P(RayMasksTest, RaysMeetWhatTheyMeetInASceneOfTheseGeometriesAlone) {
  for (const bool robust : {false, true}) {
    const auto scene = MakeScene(meshes_, robust);
    const auto little = MakeScene(meshes_, robust, Keep::kLittle);  // makes leaves for each visit
    for (const bool run_together : {false, true}) {
      for (const Query query : {Query::kClosest, Query::kAny}) {
        const auto rays = MakeRays(run_together, 1600);
        const auto expected = Expected(rays, query, robust);
        const std::string what = std::string(robust ? "robust " : "") +
                                 (query == Query::kAny ? "any " : "closest ") +
                                 (run_together ? "together " : "apart ");
        for (int round = 0; round < 2; ++round) {  // the first one splits the scene
          for (const std::size_t count : {1u, 3u, 64u, 200u, 1600u}) {
            ExpectSame(TraceInCalls(*scene, rays, query, count), expected,
                       what + "in calls of " + std::to_string(count));
          }
          for (const uint32_t lanes : {1u, 4u, 8u, 16u}) {
            ExpectSame(TracePackets(*scene, rays, query, lanes, nullptr), expected,
                       what + "in packets of " + std::to_string(lanes));
          }
        }
        ExpectSame(TracePackets(*little, rays, query, 1, nullptr), expected, what + "one by one");
        if (HasFatalFailure()) return;
      }
    }
  }
}

INSTANTIATE_ON_EACH_INSTRUCTION_SET(RayMasksTest);

}  // namespace
}  // namespace dacrt::unit
