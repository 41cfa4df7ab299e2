// Filter functions that accept most hits are asked last. Rays that go alone, as packets, as groups
// and as lists, of which each way has its own place where they are asked.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/callback_of.h"
#include "dacrt/ray.h"
#include "shape_scenes.h"
#include "trace/filter_answers.h"

namespace dacrt {
namespace {

using unit::MakeScene;
using unit::Model;
using unit::Random;

/// Calls of so many rays, as packets or as a view.
struct Calls {
  std::size_t rays;
  bool as_packets;
  bool run_together;  ///< from one point, in nearly the same direction
};

const Calls kWays[] = {{1, true, false},   {4, true, false},    {8, true, true},
                       {16, true, false},  {64, false, true},   {64, false, false},
                       {200, false, true}, {2000, false, true}, {2000, false, false}};

std::string NameOf(const Calls& calls) {
  return (calls.as_packets ? "packets of " : "calls of ") + std::to_string(calls.rays) +
         (calls.run_together ? " that run together" : "");
}

std::vector<RayHit> MakeRays(Random& random, std::size_t count, const Calls& calls) {
  std::vector<RayHit> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const bool together = calls.run_together;
    const unit::Float3 org = together ? unit::Float3{0, 0, -3} : random.InCube(-2, 2);
    const unit::Float3 dir =
        together ? unit::Float3{random.Uniform(-0.1f, 0.1f), random.Uniform(-0.1f, 0.1f), 1}
                 : random.Direction();
    std::copy_n(org.begin(), 3, rays[i].ray.org);
    std::copy_n(dir.begin(), 3, rays[i].ray.dir);
    rays[i].ray.id = static_cast<uint32_t>(i);
    rays[i].ray.mask = i % 7 == 0 ? 1 : UINT32_MAX;
  }
  return rays;
}

void TracePackets(const Scene& scene, std::vector<RayHit>& rays, uint32_t lanes) {
  std::vector<uint32_t> values(lanes * kPacketComponents);
  CallbackArguments arguments{};  // as which ReadLane reads packets
  arguments.width = lanes;
  arguments.packet = values.data();
  const RayPacket packet{values.data(), lanes};
  for (std::size_t first = 0; first + lanes <= rays.size(); first += lanes) {
    for (uint32_t lane = 0; lane < lanes; ++lane) {
      const auto bits = std::bit_cast<std::array<uint32_t, kPacketComponents>>(rays[first + lane]);
      for (std::size_t c = 0; c < kPacketComponents; ++c) values[c * lanes + lane] = bits[c];
    }
    scene.Trace(Query::kClosest, packet, {lanes, nullptr});
    for (uint32_t lane = 0; lane < lanes; ++lane) rays[first + lane] = ReadLane(arguments, lane);
  }
}

/// The rays with what they hit.
std::vector<RayHit> Trace(const Scene& scene, std::vector<RayHit> rays, const Calls& calls) {
  if (calls.as_packets) {
    TracePackets(scene, rays, static_cast<uint32_t>(calls.rays));
    return rays;
  }
  for (std::size_t first = 0; first < rays.size(); first += calls.rays) {
    const std::size_t count = std::min(calls.rays, rays.size() - first);
    scene.Trace(Query::kClosest, ViewOf(std::span(rays).subspan(first, count)), {8, nullptr});
  }
  return rays;
}

using Pair = std::pair<uint32_t, uint32_t>;  ///< of a ray and a triangle

Pair PairOf(const RayHit& hit) {
  return {hit.ray.id, 10000 * hit.hit.geometry_id + hit.hit.primitive_id};
}

/// Notes what it is asked about, and rejects a third of the triangles once it is told to.
struct NotingFilter {
  bool operator()(const RayHit& candidate, const CallbackArguments& arguments) {
    EXPECT_EQ(candidate.hit.geometry_id, arguments.geometry_id);
    const RayHit in_lane = ReadLane(arguments, candidate.ray.id % arguments.width);
    are_in_their_lanes &= in_lane.ray.id == candidate.ray.id;
    shown.push_back(PairOf(candidate));
    return !rejects || candidate.hit.primitive_id % 3 != 0;
  }

  bool rejects = false;
  bool are_in_their_lanes = true;
  std::vector<Pair> shown;
};

/// Two geometries with a filter function, one of which not all rays meet, and one without.
class AskLastTest : public testing::TestWithParam<Calls> {
 protected:
  AskLastTest() {
    for (uint32_t i = 0; i < 3; ++i) {
      models_[i] = unit::MakeTriangles(random_, 1500);
      geometries_.push_back(unit::TriangleView(models_[i], i));
    }
    geometries_[0].closest_filter = FilterOf(filter_);
    geometries_[2].closest_filter = FilterOf(filter_);
    geometries_[2].mask = 2;
  }

  /// The rays against a scene that has learnt that next to all hits are accepted.
  std::vector<RayHit> TraceLearnt(const Scene& scene, const std::vector<RayHit>& rays) {
    filter_.rejects = false;
    // So many that what another scene, which stood in its place before, had rejected is forgotten.
    constexpr std::size_t kToLearnFrom = 4000;
    filter_.shown.clear();
    while (filter_.shown.size() < kToLearnFrom) Trace(scene, rays, GetParam());
    filter_.shown.clear();
    filter_.are_in_their_lanes = true;
    filter_.rejects = rejects_;
    return Trace(scene, rays, GetParam());
  }

  Random random_{1};
  Model models_[3];
  std::vector<Geometry> geometries_;
  NotingFilter filter_;
  bool rejects_ = false;
};
INSTANTIATE_TEST_SUITE_P(, AskLastTest, testing::ValuesIn(kWays), [](const auto& info) {
  std::string name = NameOf(info.param);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

void ExpectSame(const std::vector<RayHit>& actual, const std::vector<RayHit>& expected) {
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_EQ(std::memcmp(&actual[i], &expected[i], sizeof(RayHit)), 0)
        << "ray " << i << ": t " << actual[i].ray.tfar << " triangle " << actual[i].hit.primitive_id
        << ", expected " << expected[i].ray.tfar << " triangle " << expected[i].hit.primitive_id;
  }
}

// No hit but the one that a ray has in the end is asked about, where all are accepted.
TEST_P(AskLastTest, OnlyHitsInTheEndAreShown) {
  const auto scene = MakeScene(geometries_, kDefaultBudget);
  const std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  const std::vector<RayHit> hits = TraceLearnt(*scene, rays);
  std::vector<Pair> expected;
  for (const RayHit& hit : hits) {
    if (hit.hit && hit.hit.geometry_id != 1) {
      expected.push_back(PairOf(hit));
    }
  }
  EXPECT_GT(expected.size(), 300u);
  std::sort(filter_.shown.begin(), filter_.shown.end());
  EXPECT_EQ(filter_.shown, expected);
  if (GetParam().as_packets) {
    EXPECT_TRUE(filter_.are_in_their_lanes);
  }
  for (Geometry& geometry : geometries_) geometry.closest_filter = {};
  ExpectSame(hits, Trace(*MakeScene(geometries_, kDefaultBudget), rays, GetParam()));
}

// A ray whose hit is rejected all the same has the next one that is not, and nothing is shown to it
// twice.
TEST_P(AskLastTest, WhatIsRejectedIsLeftOut) {
  rejects_ = true;
  const auto scene = MakeScene(geometries_, kDefaultBudget);
  const std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  const std::vector<RayHit> hits = TraceLearnt(*scene, rays);
  std::sort(filter_.shown.begin(), filter_.shown.end());
  EXPECT_EQ(std::adjacent_find(filter_.shown.begin(), filter_.shown.end()), filter_.shown.end());
  // By the published method, which keeps nothing and so asks at once.
  ExpectSame(hits, Trace(*MakeScene(geometries_, 0), rays, GetParam()));
}

// Where many are rejected, rays would begin anew, so these are asked about at once.
TEST_P(AskLastTest, WhereManyAreRejectedAllAreShownAtOnce) {
  rejects_ = true;
  const auto scene = MakeScene(geometries_, kDefaultBudget);
  const std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  TraceLearnt(*scene, rays);
  Trace(*scene, rays, GetParam());
  filter_.rejects = false;
  filter_.shown.clear();
  std::size_t filtered = 0;
  for (const RayHit& hit : Trace(*scene, rays, GetParam())) {
    filtered += hit.hit && hit.hit.geometry_id != 1;
  }
  EXPECT_GT(filter_.shown.size(), filtered + filtered / 8);
}

/// Calls a user's function, which hits nothing, and counts for which rays.
struct NotingUser {
  Geometry Describe() {
    Geometry geometry;
    geometry.shape = Shape::kUser;
    geometry.geometry_id = 7;
    geometry.primitive_count = 1;
    geometry.bounds = {[](void*, uint32_t, uint32_t, Bounds& bounds) {
                         bounds = {{-3, -3, -3}, {3, 3, 3}};
                       },
                       nullptr};
    geometry.intersect = {
        [](void* data, const CallbackArguments& arguments) {
          for (uint32_t lane = 0; lane < arguments.width; ++lane) {
            if (!arguments.valid[lane]) continue;
            static_cast<NotingUser*>(data)->rays.push_back(ReadLane(arguments, lane).ray.id);
          }
        },
        this};
    return geometry;
  }

  std::vector<uint32_t> rays;
};

// A ray that began anew would be seen twice by a user's function.
TEST_P(AskLastTest, UserFunctionsSeeRaysOnce) {
  NotingUser user;
  geometries_.push_back(user.Describe());
  const auto scene = MakeScene(geometries_, kDefaultBudget);
  const std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  TraceLearnt(*scene, rays);
  user.rays.clear();
  filter_.rejects = true;
  Trace(*scene, rays, GetParam());
  EXPECT_GT(user.rays.size(), rays.size() / 2);
  std::sort(user.rays.begin(), user.rays.end());
  EXPECT_EQ(std::adjacent_find(user.rays.begin(), user.rays.end()), user.rays.end());
}

// Where two geometries have one ID, a hit does not tell whose function is to be asked.
TEST_P(AskLastTest, GeometriesWithOneIdAskTheirOwnFunctions) {
  NotingFilter other;
  for (Geometry& geometry : geometries_) geometry.geometry_id = 5;
  geometries_[1].closest_filter = FilterOf(other);
  const auto scene = MakeScene(geometries_, kDefaultBudget);
  const std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  rejects_ = true;
  const std::vector<RayHit> hits = TraceLearnt(*scene, rays);
  ExpectSame(hits, Trace(*MakeScene(geometries_, 0), rays, GetParam()));
}

// The same of geometries in an instance, whose IDs are those of another scene.
TEST_P(AskLastTest, InstancesAskTheirOwnFunctions) {
  NotingFilter other;
  const Model inside = unit::MakeTriangles(random_, 1500);
  const std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  rejects_ = true;
  const auto trace = [&](uint64_t budget) {
    Settings settings;
    settings.budget = budget;
    const auto device = std::make_shared<Device>(settings);
    Geometry inner = unit::TriangleView(inside, 0);
    inner.closest_filter = FilterOf(other);
    Geometry instance;
    instance.shape = Shape::kInstance;
    instance.geometry_id = 9;
    instance.primitive_count = 1;
    instance.instanced_scene =
        std::make_shared<Scene>(device, std::span<const Geometry>(&inner, 1), SceneOptions{});
    instance.transforms.resize(1);
    std::vector<Geometry> geometries = geometries_;
    geometries.push_back(instance);
    return TraceLearnt(Scene(device, geometries, SceneOptions{}), rays);
  };
  ExpectSame(trace(kDefaultBudget), trace(0));
}

/// Accepts all hits, and moves them away or towards the ray's origin.
struct MovingFilter {
  bool operator()(RayHit& candidate) const {
    candidate.ray.tfar *= factor;
    return true;
  }

  float factor = 1;
};

// Two triangles, of which the nearer one's hits are moved: behind the other one, to before it, and
// towards the ray.
TEST_P(AskLastTest, HitsAreWhereTheFilterFunctionPutsThem) {
  std::vector<RayHit> rays = MakeRays(random_, 2000, GetParam());
  for (RayHit& ray : rays) {
    ray.ray = {.org = {random_.Uniform(-1, 1), random_.Uniform(-1, 1), 0},
               .dir = {random_.Uniform(-1, 1), random_.Uniform(-1, 1), 1}};
  }
  Model layers[2];
  for (uint32_t i = 0; i < 2; ++i) {
    const float z = static_cast<float>(i + 1);
    layers[i].steps = {{-9, -9, z, 9, -9, z, 0, 9, z}};
    layers[i].indices = {0, 1, 2};
  }
  MovingFilter moving;
  Geometry near = unit::TriangleView(layers[0], 0);
  near.closest_filter = FilterOf(moving);
  const auto scene = MakeScene({near, unit::TriangleView(layers[1], 1)}, kDefaultBudget);
  for (const float factor : {3.0f, 1.5f, 0.25f}) {
    moving.factor = 1;
    for (int round = 0; round < 3; ++round) Trace(*scene, rays, GetParam());
    moving.factor = factor;
    for (const RayHit& hit : Trace(*scene, rays, GetParam())) {
      ASSERT_EQ(hit.hit.geometry_id, factor < 2 ? 0 : 1) << "moved by " << factor;
      ASSERT_NEAR(hit.ray.tfar, factor < 2 ? factor : 2, 1e-5f) << "moved by " << factor;
    }
  }
}

TEST(FilterAnswersTest, MostAreAcceptedUntilAThirtiethIsRejected) {
  FilterAnswers answers;
  EXPECT_FALSE(answers.AcceptMost()) << "nothing was seen";
  answers.Count(64, 64);
  EXPECT_TRUE(answers.AcceptMost());
  answers.Count(2, 0);
  EXPECT_TRUE(answers.AcceptMost());
  answers.Count(1, 0);
  EXPECT_FALSE(answers.AcceptMost());
  answers.Count(100, 0);
  for (int i = 0; i < 1000; ++i) answers.Count(8, 8);
  EXPECT_TRUE(answers.AcceptMost()) << "what was long ago counts no more";
  answers.Count(40, 0);
  EXPECT_FALSE(answers.AcceptMost());
}

TEST(FilterAnswersTest, AreThoseOfOneScene) {
  FilterAnswers::Of(8).Count(64, 64);
  EXPECT_TRUE(FilterAnswers::Of(8).AcceptMost());
  EXPECT_FALSE(FilterAnswers::Of(9).AcceptMost());
  EXPECT_TRUE(FilterAnswers::Of(8).AcceptMost()) << "while another scene is traced";
  EXPECT_FALSE(FilterAnswers::Of(4000).AcceptMost()) << "in the same place";
  EXPECT_FALSE(FilterAnswers::Of(8).AcceptMost()) << "forgotten for that";
}

}  // namespace
}  // namespace dacrt
