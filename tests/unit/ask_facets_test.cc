// Filter functions that are asked at once, where rays go by lists: several rays are asked about
// together, and get what each would get alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <numeric>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "dacrt/callback_of.h"
#include "dacrt/ray.h"
#include "shape_scenes.h"

namespace dacrt {
namespace {

using unit::MakeScene;
using unit::Model;
using unit::Random;

/// Accepts of each ray other triangles than of the next one, and changes some of the hits.
struct NotingFilter {
  bool operator()(RayHit& candidate, const CallbackArguments& arguments) {
    EXPECT_EQ(candidate.hit.geometry_id, arguments.geometry_id);
    const auto valid = std::count(arguments.valid, arguments.valid + arguments.width, -1);
    most_together = std::max(most_together, static_cast<std::size_t>(valid));
    const uint32_t triangle = 10000 * candidate.hit.geometry_id + candidate.hit.primitive_id;
    ++shown[{candidate.ray.id, triangle}];
    const uint32_t chance = 31 * candidate.ray.id + 7 * triangle;
    if (chance % 5 == 0) candidate.hit.u = static_cast<float>(candidate.ray.id);
    return chance % 3 != 0;
  }

  std::map<std::pair<uint32_t, uint32_t>, int> shown;  ///< pairs of a ray and a triangle
  std::size_t most_together = 0;
};

/// Triangles of two geometries with a filter function and one without, several close together, so
/// that a ray that meets one meets others of its leaf.
class AskFacetsTest : public testing::TestWithParam<Query> {
 protected:
  AskFacetsTest() {
    Random random(1);
    const Model some = unit::MakeTriangles(random, 300);
    for (uint32_t i = 0; i < 3; ++i) {
      Model& model = models_[i];
      model.steps.resize(1);
      for (const uint32_t copy : {i, 3 + i}) {
        for (const float value : some.steps[0]) {
          model.steps[0].push_back(value + 1e-3f * static_cast<float>(copy));
        }
      }
      model.indices.resize(model.steps[0].size() / 3);
      std::iota(model.indices.begin(), model.indices.end(), 0);
      geometries_.push_back(unit::TriangleView(models_[i], i));
      if (i != 1) geometries_[i].closest_filter = geometries_[i].any_filter = FilterOf(filter_);
    }
    rays_.resize(3000);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const unit::Float3 org = random.InCube(-2, 2), dir = random.Direction();
      std::copy_n(org.begin(), 3, rays_[i].ray.org);
      std::copy_n(dir.begin(), 3, rays_[i].ray.dir);
      rays_[i].ray.id = static_cast<uint32_t>(i);
    }
  }

  /// The rays with what they hit, in calls of so many, and packets of as many lanes.
  std::vector<RayHit> Trace(const Scene& scene, std::size_t rays_a_call, uint32_t lanes) {
    std::vector<RayHit> rays = rays_;
    for (std::size_t first = 0; first < rays.size(); first += rays_a_call) {
      scene.Trace(GetParam(), ViewOf(std::span(rays).subspan(first, rays_a_call)),
                  {lanes, nullptr});
    }
    return rays;
  }

  Model models_[3];
  std::vector<Geometry> geometries_;
  std::vector<RayHit> rays_;
  NotingFilter filter_;
};
INSTANTIATE_TEST_SUITE_P(, AskFacetsTest, testing::Values(Query::kClosest, Query::kAny),
                         [](const auto& info) {
                           return info.param == Query::kAny ? "Any" : "Closest";
                         });

// In a thread for each scene, all of which are there until the end: which way rays go is learnt by
// the clock, and a thread that has seen many scenes may know one of the same address.
TEST_P(AskFacetsTest, RaysOfListsGetWhatTheyGetAlone) {
  const auto check = [&](const Scene& scene, uint64_t budget) {
    const std::vector<RayHit> alone = Trace(scene, 1, 1);
    for (const uint32_t lanes : {4u, 8u, 16u}) {
      for (int round = 0; round < 4; ++round) {  // by lists, and as groups
        filter_ = {};
        const std::vector<RayHit> together = Trace(scene, rays_.size(), lanes);
        for (std::size_t i = 0; i < together.size(); ++i) {
          ASSERT_EQ(std::memcmp(&together[i], &alone[i], sizeof(RayHit)), 0)
              << "ray " << i << ", " << lanes << " lanes, budget " << budget;
        }
        for (const auto& [pair, times] : filter_.shown) ASSERT_EQ(times, 1);
        EXPECT_GE(filter_.most_together, 4u);
      }
    }
  };
  std::vector<std::shared_ptr<Scene>> scenes;
  for (const bool robust : {false, true}) {
    for (const uint64_t budget : {uint64_t{8 * 1800}, kDefaultBudget}) {
      scenes.push_back(MakeScene(geometries_, budget, robust));
      std::thread([&] { check(*scenes.back(), budget); }).join();
    }
  }
}

}  // namespace
}  // namespace dacrt
