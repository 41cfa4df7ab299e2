// Rays through instances, close together and anyhow: in groups and lists they find what each finds
// alone, to the last bit.
#include <algorithm>
#include <array>
#include <bit>
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

class GroupInstancesTest : public unit::OnEachInstructionSet {};
INSTANTIATE_ON_EACH_INSTRUCTION_SET(GroupInstancesTest);

/// A hilly sheet in [-1, 1]^2.
Mesh Sheet(uint32_t side, uint32_t id, float height) {
  Mesh mesh;
  mesh.geometry_id = id;
  const auto at = [&](uint32_t x, uint32_t y) -> Float3 {
    const float u = 2.0f * static_cast<float>(x) / static_cast<float>(side) - 1;
    const float v = 2.0f * static_cast<float>(y) / static_cast<float>(side) - 1;
    return {u, v, height * std::sin(9 * u) * std::cos(7 * v)};
  };
  for (uint32_t y = 0; y < side; ++y) {
    for (uint32_t x = 0; x < side; ++x) {
      mesh.Add(at(x, y), at(x + 1, y), at(x, y + 1));
      mesh.Add(at(x + 1, y + 1), at(x, y + 1), at(x + 1, y));
    }
  }
  return mesh;
}

Geometry Instance(const std::shared_ptr<const Scene>& scene, uint32_t id, float turn, float z) {
  Geometry geometry;
  geometry.shape = Shape::kInstance;
  geometry.geometry_id = id;
  geometry.primitive_count = 1;
  geometry.instanced_scene = scene;
  geometry.transforms.resize(1);
  auto& column = geometry.transforms[0].matrix.column;
  column[0][0] = column[1][1] = std::cos(turn);
  column[0][1] = std::sin(turn);
  column[1][0] = -std::sin(turn);
  column[3][2] = z;
  return geometry;
}

/// As from a camera above, in rows of a picture.
std::vector<FullRay> Picture(uint32_t side, float width) {
  std::vector<FullRay> rays;
  for (uint32_t y = 0; y < side; ++y) {
    for (uint32_t x = 0; x < side; ++x) {
      const auto place = [&](uint32_t i) {
        return width * (2 * (static_cast<float>(i) + 0.37f) / static_cast<float>(side) - 1);
      };
      rays.push_back(unit::FullRayOf(unit::MakeRay({0.1f, 0.05f, 4}, {place(x), place(y), -1})));
    }
  }
  return rays;
}

/// What a function sees of the ray in a lane.
uint32_t& ValueOf(const CallbackArguments& arguments, PacketComponent component, uint32_t lane) {
  return static_cast<uint32_t*>(
      arguments.packet)[static_cast<std::size_t>(component) * arguments.width + lane];
}

/// Rejects every third primitive, and changes the hits on others.
void RejectAndChange(void*, const CallbackArguments& arguments) {
  for (uint32_t lane = 0; lane < arguments.width; ++lane) {
    if (arguments.valid[lane] == 0) continue;
    const uint32_t primitive = ValueOf(arguments, PacketComponent::kPrimitiveId, lane);
    if (primitive % 3 == 0) arguments.valid[lane] = 0;
    if (primitive % 7 == 0) ValueOf(arguments, PacketComponent::kU, lane) = primitive;
  }
}

// Instances in one another, two of them in the same place under other numbers, a still mesh among
// them, and one that is hit first and lies behind what the others hide.
void ExpectAsEachRayAlone(bool robust, bool filtered, const std::shared_ptr<Device>& device) {
  const Mesh fine = Sheet(24, 5, 0.2f), coarse = Sheet(6, 2, 0.1f), floor = Sheet(10, 7, 0.3f);
  const SceneOptions options{.robust = robust};
  Geometry finely = GeometryOf(fine);
  if (filtered) finely.closest_filter = finely.any_filter = {RejectAndChange, nullptr};
  const auto first = std::make_shared<Scene>(device, finely, options);
  const auto second = std::make_shared<Scene>(device, GeometryOf(coarse), options);
  const std::vector<Geometry> geometries = {
      Instance(first, 9, 0.3f, 0.1f), Instance(second, 4, 0.3f, 0), Instance(first, 3, 0.3f, 0.1f),
      Instance(second, 8, 1, -0.2f),  Instance(first, 1, 0, -0.1f), GeometryOf(floor)};
  const Scene scene(device, geometries, options);
  // Shallow ones, and ones that pass by; calls that go the short way too.
  for (const float width : {0.05f, 0.3f, 1.0f}) {
    SCOPED_TRACE("width " + std::to_string(width));
    const std::vector<FullRay> rays = Picture(48, width);
    for (const Query query : {Query::kClosest, Query::kAny}) {
      const auto alone = unit::TracePackets(scene, rays, query, 1, nullptr);
      const auto whole = unit::TraceForm(scene, rays, query);
      unit::ExpectSame(whole, alone, "one call");
      unit::ExpectSame(unit::TraceInCalls(scene, rays, query, 64), alone, "calls of 64");
      unit::ExpectSame(unit::TracePackets(scene, rays, query, 16, nullptr), alone, "packets");
      if (query == Query::kAny) continue;
      std::array<std::size_t, 10> hits{};
      for (const FullRay& ray : alone) {
        const auto instance = ray.Get<uint32_t>(PacketComponent::kInstanceId);
        if (instance < hits.size()) ++hits[instance];
      }
      EXPECT_GT(hits[3], 0u) << "the smaller number of two in one place";
      EXPECT_GT(hits[4], 0u);
      EXPECT_EQ(hits[9], 0u);
    }
  }
}

TEST_P(GroupInstancesTest, AsEachRayAlone) {
  const auto device = std::make_shared<Device>(WithInstructionSet({}));
  for (const bool robust : {false, true}) {
    for (const bool filtered : {false, true}) {
      SCOPED_TRACE(std::string(robust ? "robust" : "plain") + (filtered ? ", filtered" : ""));
      ExpectAsEachRayAlone(robust, filtered, device);
    }
  }
}

/// What a user function has seen of each ray, by its ID.
struct SeenHit {
  uint32_t geometry = UINT32_MAX;
  float u = 0, tfar = 0;

  bool operator==(const SeenHit&) const = default;
};

void See(void* data, const CallbackArguments& arguments) {
  auto& seen = *static_cast<std::vector<SeenHit>*>(data);
  for (uint32_t lane = 0; lane < arguments.width; ++lane) {
    if (arguments.valid[lane] == 0) continue;
    const auto value = [&](PacketComponent component) {
      return ValueOf(arguments, component, lane);
    };
    using enum PacketComponent;
    seen[value(kId)] = {value(kGeometryId), std::bit_cast<float>(value(kU)),
                        std::bit_cast<float>(value(kTfar))};
  }
}

// A user function in an instance is shown what a ray has hit before, outside of it.
TEST_P(GroupInstancesTest, UserFunctionsAreShownWhatWasHitOutside) {
  Mesh slope;  // its bounds begin before the user primitive's, and rays hit it behind that
  slope.geometry_id = 7;
  slope.Add({-3, -3, 2}, {3, -3, -2}, {0, 4, -2});
  std::vector<FullRay> rays = Picture(16, 0.1f);
  for (uint32_t i = 0; i < rays.size(); ++i) rays[i].Set(PacketComponent::kId, i);
  std::vector<SeenHit> seen(rays.size());
  Geometry user;
  user.shape = Shape::kUser;
  user.geometry_id = 2;
  user.primitive_count = 1;
  user.bounds = {[](void*, uint32_t, uint32_t, Bounds& bounds) {
                   bounds = {{-1, -1, 0.5f}, {1, 1, 1}};
                 },
                 nullptr};
  user.intersect = {See, &seen};
  const auto device = std::make_shared<Device>(WithInstructionSet({}));
  const auto instanced = std::make_shared<Scene>(device, user);
  const Scene scene(device, std::vector<Geometry>{GeometryOf(slope), Instance(instanced, 9, 0, 0)});
  const auto seen_by = [&](const auto& trace) {
    std::ranges::fill(seen, SeenHit{});
    trace();
    return seen;
  };
  const auto alone = seen_by([&] { unit::TracePackets(scene, rays, Query::kClosest, 1, nullptr); });
  EXPECT_EQ(seen_by([&] { unit::TracePackets(scene, rays, Query::kClosest, 16, nullptr); }), alone);
  EXPECT_EQ(seen_by([&] { unit::TraceInCalls(scene, rays, Query::kClosest, 64); }), alone);
  for (const SeenHit& hit : alone) EXPECT_EQ(hit.geometry, 7u);
}

// Where T <= |den| tfar fails by a rounding and T / |den| is tfar all the same, a triangle is not
// hit; one that is hit at tfar, in an instance, does not make a limit of another kind of it.
TEST_P(GroupInstancesTest, AHitAtTheLimitLeavesItTheLimit) {
  const Mesh sheet = Sheet(24, 5, 0.2f);
  Mesh turned = sheet;  // the same triangles from the next corner on: their rounding differs
  turned.geometry_id = 1;
  for (auto& triangle : turned.triangles)
    std::rotate(triangle.begin(), triangle.begin() + 1, triangle.end());
  const auto device = std::make_shared<Device>(WithInstructionSet({}));
  const auto instanced = std::make_shared<Scene>(device, GeometryOf(sheet));
  const Scene scene(device,
                    std::vector<Geometry>{Instance(instanced, 9, 0, 0), GeometryOf(turned)});
  std::vector<FullRay> rays = Picture(48, 0.3f);
  unit::Random random(1);
  for (int i = 0; i < 4000; ++i) {
    const Float3 from = random.InCube(-1, 1), to = random.InCube(-1, 1);
    rays.push_back(unit::FullRayOf(
        unit::MakeRay({from[0], from[1], 1.5f}, {to[0] - from[0], to[1] - from[1], -1.5f})));
  }
  const auto hits = unit::TracePackets(scene, rays, Query::kClosest, 1, nullptr);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i].Set(PacketComponent::kTfar, hits[i].Get(PacketComponent::kTfar));
  }
  const auto alone = unit::TracePackets(scene, rays, Query::kClosest, 1, nullptr);
  unit::ExpectSame(unit::TraceForm(scene, rays, Query::kClosest), alone, "one call");
  unit::ExpectSame(unit::TraceInCalls(scene, rays, Query::kClosest, 64), alone, "calls of 64");
  unit::ExpectSame(unit::TracePackets(scene, rays, Query::kClosest, 16, nullptr), alone, "packets");
  EXPECT_GT(std::ranges::count_if(alone,
                                  [](const FullRay& ray) {
                                    return ray.Get<uint32_t>(PacketComponent::kInstanceId) == 9;
                                  }),
            100);
}

}  // namespace
}  // namespace dacrt
