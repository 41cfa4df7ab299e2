// Rays through the shared edges of a closed surface: robust scenes lose no more of them than
// Embree's own bound, other scenes no more than Embree's.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <tuple>

#include "contest.h"
#include "random.h"

namespace dacrt::tests {
namespace {

constexpr uint32_t kSteps = 500;
constexpr std::size_t kRays = 200'000;
/// Embree's tests allow this share of the rays to get through, at this tessellation.
constexpr double kLostInRobustScenes = 0.00002;

TestScene Sphere() {
  TestMesh mesh;
  const float pi = std::numbers::pi_v<float>;
  for (uint32_t i = 0; i <= kSteps; ++i) {
    const float theta = pi * static_cast<float>(i) / kSteps;
    // The poles are points, and stay that.
    const float radius = i == 0 || i == kSteps ? 0 : std::sin(theta);
    for (uint32_t k = 0; k < kSteps; ++k) {
      const float phi = 2 * pi * static_cast<float>(k) / kSteps;
      mesh.positions.push_back({radius * std::cos(phi), std::cos(theta), radius * std::sin(phi)});
      if (i == kSteps) continue;
      const uint32_t a = i * kSteps + k, b = i * kSteps + (k + 1) % kSteps;
      mesh.triangles.push_back({{a, b, a + kSteps}});
      mesh.triangles.push_back({{b, b + kSteps, a + kSteps}});
    }
  }
  return {"sphere", {mesh}, {}};
}

/// Rays from within the sphere through points of the edges.
std::vector<RTCRayHit> RaysThroughEdges(const TestMesh& mesh) {
  Random random(5);
  std::vector<RTCRayHit> rays(kRays);
  for (RTCRayHit& record : rays) {
    const Triangle& triangle = mesh.triangles[random.Below(2 * kSteps * kSteps)];
    const uint32_t side = random.Below(3);
    const Float3 a = mesh.positions[triangle.vertex[side]];
    const Float3 b = mesh.positions[triangle.vertex[(side + 1) % 3]];
    const Float3 origin{random.Uniform(-0.5f, 0.5f), random.Uniform(-0.5f, 0.5f),
                        random.Uniform(-0.5f, 0.5f)};
    const Float3 direction = a + random.Uniform(0, 1) * (b - a) - origin;
    record.ray = {origin.x,    origin.y, origin.z, 0,          direction.x, direction.y,
                  direction.z, 0,        INFINITY, UINT32_MAX, 0,           0};
    record.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    record.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
  return rays;
}

std::size_t CountLost(const EmbreeApi& api, const std::string& config, RTCSceneFlags flags,
                      bool coherent) {
  static const TestScene sphere = Sphere();
  static const std::vector<RTCRayHit> rays = RaysThroughEdges(sphere.meshes[0]);
  const EmbreeDevice device(api, config);
  const EmbreeScene scene(device, sphere, flags);
  std::size_t lost = 0;
  for (const RTCRayHit& record :
       Trace(scene, {Form::Call::kRecords, coherent}, Query::kClosest, rays)) {
    lost += record.hit.geomID == RTC_INVALID_GEOMETRY_ID;
  }
  return lost;
}

class WatertightTest : public testing::TestWithParam<std::tuple<std::string, bool>> {};
INSTANTIATE_TEST_SUITE_P(, WatertightTest,
                         testing::Combine(testing::ValuesIn(IsaConfigs()), testing::Bool()));

TEST_P(WatertightTest, RobustScenes) {
  const auto [config, coherent] = GetParam();
  EXPECT_LE(CountLost(DropIn(), config, RTC_SCENE_FLAG_ROBUST, coherent),
            kLostInRobustScenes * kRays);
}

TEST_P(WatertightTest, OtherScenesLoseNoMoreThanEmbrees) {
  const auto [config, coherent] = GetParam();
  EXPECT_LE(CountLost(DropIn(), config, RTC_SCENE_FLAG_NONE, coherent),
            CountLost(RealEmbree(), config, RTC_SCENE_FLAG_NONE, coherent));
}

}  // namespace
}  // namespace dacrt::tests
