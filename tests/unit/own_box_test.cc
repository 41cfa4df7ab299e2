// Rays that nearly lie in the planes of triangles: where they meet these is off by more than the
// triangles' boxes are deep, so that what they meet nearest may not count. The answer is the same
// whichever box is asked when: at once, or last (leaf/own_box-inl.h), or those of all triangles,
// which is what a scene that keeps nothing does.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grazed_slab.h"
#include "kept_trace.h"

namespace dacrt {
namespace {

using unit::Float3;
using unit::FullRay;
using unit::Mesh;

class OwnBoxTest : public unit::OnEachInstructionSet {};
INSTANTIATE_ON_EACH_INSTRUCTION_SET(OwnBoxTest);

/// Some that are full of triangles, each with rays that come to it.
struct Slabs {
  static constexpr int kTriangles = 20, kRays = 100;

  Slabs(unit::Random& random, int count) {
    for (int done = 0; done < count; ++done) {
      unit::GrazedSlab slab(random);
      for (int i = 0; i < kTriangles; ++i) mesh.Add(slab.Point(), slab.Point(), slab.Point());
      for (int i = 0; i < kRays; ++i) {
        unit::Ray ray = slab.MakeGrazingRay();
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
void ExpectTheSame(const Slabs& slabs, bool robust, bool moves, Settings settings) {
  const auto device = std::make_shared<Device>(settings);
  settings.budget = 0;
  const SceneOptions options{.robust = robust};
  Geometry geometry = unit::GeometryOf(slabs.mesh);
  // On the spot: at time 0 a triangle is what it is when it stands still.
  if (moves) geometry.vertices.push_back(geometry.vertices[0]);
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
    ExpectTheSame(Slabs(random, 120), robust, false, WithInstructionSet({}));
  }
}

TEST_P(OwnBoxTest, NorInSmallScenes) {
  unit::Random random(2);
  for (int i = 0; i < 120; ++i) {
    ExpectTheSame(Slabs(random, 1), false, i % 2 != 0, WithInstructionSet({}));
    if (testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace dacrt
