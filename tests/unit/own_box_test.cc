// Rays that nearly lie in the planes of triangles: where they meet these is off by more than the
// triangles' boxes are deep, so that what they meet nearest may not count. The answer is the same
// whichever box is asked when: at once, or last (leaf/own_box-inl.h), or those of all triangles,
// which is what a scene that keeps nothing does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "film.h"
#include "kept_trace.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::FullRay;
using unit::Mesh;

class OwnBoxTest : public unit::OnEachInstructionSet {};
INSTANTIATE_ON_EACH_INSTRUCTION_SET(OwnBoxTest);

/// Slabs far away, thin and full of triangles, each of which contains the way from one origin of
/// rays.
struct Slabs {
  static constexpr int kTriangles = 20, kRays = 100;

  Slabs(unit::Random& random, int count) {
    for (int slab = 0; slab < count; ++slab) {
      const float distance = std::exp2(random.Uniform(4, 12));
      const float size = std::exp2(random.Uniform(-8, 0));
      const float flatness = std::exp2(random.Uniform(-16, -8));
      const Float3 org = random.InCube(-1, 1), way = random.Direction();
      const auto dot = [](const Float3& a, const Float3& b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
      };
      Float3 normal = random.Direction();
      const float along = dot(normal, way);
      for (std::size_t axis = 0; axis < 3; ++axis) normal[axis] -= along * way[axis];
      const auto point = [&] {
        Float3 at = random.InCube(-size, size);
        const float height = (1 - flatness) * dot(at, normal) / dot(normal, normal);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          at[axis] += org[axis] + distance * way[axis] - height * normal[axis];
        }
        return at;
      };
      for (int i = 0; i < kTriangles; ++i) mesh.Add(point(), point(), point());
      for (int i = 0; i < kRays; ++i) {
        Float3 dir = point();
        for (std::size_t axis = 0; axis < 3; ++axis) dir[axis] -= org[axis];
        unit::Ray ray = unit::MakeRay(org, dir);
        if (i % 4 == 0) ray.tfar = random.Uniform(0.999f, 1.001f);
        rays.push_back(unit::FullRayOf(ray));
      }
    }
    // In no order: rays that run close together go another way.
    for (std::size_t i = rays.size(); i > 1; --i) std::swap(rays[i - 1], rays[random.Below(i)]);
  }

  Mesh mesh;
  std::vector<FullRay> rays;
};

/// By every way what the published method finds.
void ExpectTheSame(const Slabs& slabs, bool robust, Settings settings) {
  const auto device = std::make_shared<Device>(settings);
  settings.budget = 0;
  const SceneOptions options{.robust = robust};
  const Geometry geometry = unit::GeometryOf(slabs.mesh);
  const Scene scene(device, geometry, options);
  const Scene published(std::make_shared<Device>(settings), geometry, options);
  for (const Query query : {Query::kClosest, Query::kAny}) {
    SCOPED_TRACE("robust " + std::to_string(robust) + " query " +
                 std::to_string(static_cast<int>(query)));
    const auto expected = unit::TraceForm(published, slabs.rays, query);
    for (int call = 0; call < 3; ++call) {
      unit::FormedRays formed(slabs.rays, unit::kRecords);
      const Statistics statistics = scene.Trace(query, formed.View());
      unit::ExpectSame(formed.Rays(), expected, "one call");
      if (query == Query::kAny || statistics.rays == 0) continue;  // short calls count nothing
      const auto is_hit = [](const FullRay& ray) {
        return ray.Get<uint32_t>(PacketComponent::kGeometryId) != UINT32_MAX;
      };
      EXPECT_EQ(statistics.hits, std::count_if(expected.begin(), expected.end(), is_hit));
    }
    unit::ExpectSame(unit::TraceInCalls(scene, slabs.rays, query, 64), expected, "calls of 64");
    for (const uint32_t lanes : {1u, 4u, 16u}) {
      unit::ExpectSame(unit::TracePackets(scene, slabs.rays, query, lanes, nullptr), expected,
                       "packets of " + std::to_string(lanes));
    }
  }
}

TEST_P(OwnBoxTest, NoMatterWhenItIsAsked) {
  unit::Random random(1);
  for (const bool robust : {false, true}) {
    ExpectTheSame(Slabs(random, 120), robust, WithInstructionSet({}));
  }
}

TEST_P(OwnBoxTest, NorInSmallScenes) {
  unit::Random random(2);
  for (int i = 0; i < 60; ++i) {
    ExpectTheSame(Slabs(random, 1), false, WithInstructionSet({}));
    if (testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace dacrt
