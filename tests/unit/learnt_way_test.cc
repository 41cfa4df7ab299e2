// Rays go one way or another, which changes nothing.
#include "trace/learnt_way.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "native_scene.h"
#include "trace/policy.h"

namespace dacrt {
namespace {

void Spin() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(20);
  while (std::chrono::steady_clock::now() < end) continue;
}

constexpr uint32_t kCalls = 4096;

/// Of kCalls calls, how many go the first way and how many the second.
std::pair<uint32_t, uint32_t> CallsOfEachWay(uint32_t run, bool first_is_quicker) {
  LearntWay way(run);
  constexpr uint32_t kRays = 64;
  uint32_t first = 0, second = 0;
  for (uint32_t i = 0; i < kCalls; ++i) {
    way.Trace(
        kRays,
        [&] {
          ++first;
          if (!first_is_quicker) Spin();
        },
        [&] {
          ++second;
          if (first_is_quicker) Spin();
        });
  }
  EXPECT_EQ(first + second, kCalls);
  return {first, second};
}

TEST(LearntWayTest, MostGoTheQuickerWay) {
  for (const uint32_t run : {512, 4096}) {
    for (const bool first_is_quicker : {false, true}) {
      const auto [first, second] = CallsOfEachWay(run, first_is_quicker);
      // The other way is tried now and then.
      const uint32_t other = first_is_quicker ? second : first;
      EXPECT_GT(other, 0u) << run;
      EXPECT_LT(other, kCalls / 4) << run;
    }
  }
}

// What the ways cost is found out with parts of a call, in turn, not with all rays that it has.
TEST(LearntWayTest, OfLargeCallsEachWayGetsParts) {
  constexpr uint32_t kRun = 512, kMany = 1 << 14;
  LearntWay way(kRun);
  uint32_t first = 0, second = 0, whole = 0;
  for (uint32_t i = 0; i < kCalls; ++i) {
    const uint32_t rays = std::min(kMany, way.MostRays());
    way.Trace(
        rays,
        [&] {
          first += rays;
          if (rays == kMany) ++whole;
        },
        [&] {
          second += rays;
          EXPECT_EQ(rays, kRun);
          Spin();
        });
  }
  EXPECT_GT(second, 0u);
  EXPECT_LT(second, first / 64);
  EXPECT_GT(whole, kCalls / 2);
}

/// Calls `trace` for some rays in a row, until all of them have had their turn.
template <class T, class Trace>
void ForEachCall(std::vector<T>& rays, const Trace& trace) {
  for (std::size_t begin = 0, call = 0; begin < rays.size(); ++call) {
    const std::size_t count = std::min(rays.size() - begin, std::size_t{1} + 37 * call % 100);
    trace(std::span(rays).subspan(begin, count));
    begin += count;
  }
}

/// A scene that is not small, and calls of few rays, enough of them for each way.
class ShortCallsTest : public testing::Test {
 protected:
  static constexpr std::size_t kRays = 1000, kRounds = 64;

  void SetUp() override {
    unit::Random random(3);
    meshes_ = {unit::MakeSoup(random, 3 * policy::kSmallScene, 1, 0.2f),
               unit::MakeSoup(random, 100, 1, 0.3f)};
    scene_ = std::make_unique<Scene>(
        device_, std::vector{Triangles(meshes_[0].vertices, meshes_[0].triangles, 7),
                             Triangles(meshes_[1].vertices, meshes_[1].triangles, 3, 2)});
    for (std::size_t i = 0; i < kRays; i += 7) rays_[i].ray.mask = static_cast<uint32_t>(i) % 4;
    for (std::size_t i = 3; i < kRays; i += 11) rays_[i].ray.tfar = 0.3f;
    found_ = rays_;
    scene_->ClosestHits(found_);
  }

  /// Blocks the rays in many calls, each way among them.
  void ExpectTheSameBlocked() {
    std::vector<Ray> before;
    for (const RayHit& ray : rays_) before.push_back(ray.ray);
    for (std::size_t round = 0; round < kRounds; ++round) {
      std::vector<Ray> rays = before;
      ForEachCall(rays, [&](std::span<Ray> some) { scene_->AnyHits(some); });
      for (std::size_t i = 0; i < kRays; ++i) {
        const float expected = found_[i].hit ? -unit::kInfinity : before[i].tfar;
        ASSERT_EQ(rays[i].tfar, expected) << i;
      }
    }
  }

  std::vector<unit::Mesh> meshes_;
  const std::shared_ptr<Device> device_ = std::make_shared<Device>();
  std::unique_ptr<Scene> scene_;
  std::vector<RayHit> rays_ = MakeRayHits(2, kRays), found_;
};

TEST_F(ShortCallsTest, FindTheSameClosestHits) {
  for (std::size_t round = 0; round < kRounds; ++round) {
    std::vector<RayHit> rays = rays_;
    ForEachCall(rays, [&](std::span<RayHit> some) { scene_->ClosestHits(some); });
    for (std::size_t i = 0; i < kRays; ++i) ASSERT_TRUE(SameBits(rays[i], found_[i])) << i;
  }
}

// Long calls go by lists until groups are tried, some rays of them.
TEST_F(ShortCallsTest, LongOnesFindTheSame) {
  constexpr std::size_t kCopies = 40, kLongRounds = 12;
  for (std::size_t round = 0; round < kLongRounds; ++round) {
    std::vector<RayHit> rays;
    std::vector<Ray> shadow_rays;
    for (std::size_t copy = 0; copy < kCopies; ++copy) {
      rays.insert(rays.end(), rays_.begin(), rays_.end());
      for (const RayHit& ray : rays_) shadow_rays.push_back(ray.ray);
    }
    scene_->ClosestHits(rays);
    scene_->AnyHits(shadow_rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const RayHit& found = found_[i % kRays];
      ASSERT_TRUE(SameBits(rays[i], found)) << i;
      const float expected = found.hit ? -unit::kInfinity : rays_[i % kRays].ray.tfar;
      ASSERT_EQ(shadow_rays[i].tfar, expected) << i;
    }
  }
}

TEST_F(ShortCallsTest, BlockTheSameRays) { ExpectTheSameBlocked(); }

TEST_F(ShortCallsTest, BlockTheSameRaysThatRunCloseTogether) {
  unit::Random random(4);
  for (RayHit& ray : rays_) {
    std::copy_n(std::array{0.0f, 0.1f, -1.5f}.data(), 3, ray.ray.org);
    ray.ray.dir[0] = random.Uniform(-0.05f, 0.05f);
    ray.ray.dir[1] = random.Uniform(-0.05f, 0.05f);
    ray.ray.dir[2] = 1;
  }
  found_ = rays_;
  scene_->ClosestHits(found_);
  ExpectTheSameBlocked();
}

}  // namespace
}  // namespace dacrt
