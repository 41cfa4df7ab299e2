#include "trace/last_blocker.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "native_scene.h"

namespace dacrt {
namespace {

TEST(LastBlockerTest, IsOfOneEdition) {
  LastBlocker& last = LastBlocker::OfThisStack();
  last.Remember(7, ChildWord::Block(5));
  ASSERT_TRUE(last.In(7));
  EXPECT_EQ(last.In(7)->bits(), ChildWord::Block(5).bits());
  EXPECT_FALSE(last.In(6));
  EXPECT_FALSE(last.In(8));
  last.Forget();
  EXPECT_FALSE(last.In(7));
}

/// Sheets of triangles across the rays that go from a point near z = -2 upwards. A sheet is two
/// geometries, which leaves have in common: their copies are not renewed before rays come.
class BlockedRaysTest : public testing::Test {
 protected:
  using Sheet = std::vector<Vector>;

  static Sheet MakeSheet(float z) {
    Sheet vertices;
    for (int y = 0; y <= kCells; ++y) {
      for (int x = 0; x <= kCells; ++x) {
        vertices.push_back({static_cast<float>(x) / kCells, static_cast<float>(y) / kCells, z});
      }
    }
    return vertices;
  }

  std::vector<Geometry> Describe(const Sheet& sheet) const {
    return {Triangles(sheet, triangles_[0], 0), Triangles(sheet, triangles_[1], 1)};
  }

  void SetUp() override {
    for (uint32_t y = 0; y < kCells; ++y) {
      for (uint32_t x = 0; x < kCells; ++x) {
        const uint32_t corner = y * (kCells + 1) + x, above = corner + kCells + 1;
        triangles_[0].push_back({corner, corner + 1, above});
        triangles_[1].push_back({above, corner + 1, above + 1});
      }
    }
  }

  /// Of rays that differ by next to nothing, as many as it takes for what is split to be found
  /// without a task, each a call.
  static void ExpectBlocked(const Scene& scene, bool is_blocked) {
    for (int i = 0; i < 200; ++i) {
      Ray ray;
      ray.org[0] = 0.51f + 1e-4f * static_cast<float>(i % 5);
      ray.org[1] = 0.53f;
      ray.org[2] = -2;
      ray.dir[2] = 1;
      ASSERT_EQ(scene.AnyHit(ray), is_blocked) << i;
    }
  }

  static constexpr int kCells = 24;
  std::vector<std::array<uint32_t, 3>> triangles_[2];
  const std::shared_ptr<Device> device_ = std::make_shared<Device>();
};

TEST_F(BlockedRaysTest, WhatIsGoneBlocksNoMore) {
  const Sheet sheet = MakeSheet(0), far_sheet = MakeSheet(-3);
  const std::vector before = Describe(sheet), after = Describe(far_sheet);
  auto scene = std::make_unique<Scene>(device_, before, SceneOptions{});
  ExpectBlocked(*scene, true);
  ASSERT_TRUE(scene->Update(after));
  ExpectBlocked(*scene, false);
  ASSERT_TRUE(scene->Update(before));
  ExpectBlocked(*scene, true);
  auto next = std::make_unique<Scene>(device_, after, SceneOptions{}, *scene);
  ASSERT_TRUE(next->takes_over());
  next->TakeOver(*scene);
  ExpectBlocked(*next, false);
}

TEST_F(BlockedRaysTest, OtherScenesBlockNothing) {
  const Sheet near_sheet = MakeSheet(0), far_sheet = MakeSheet(-3);
  const Scene blocked(device_, Describe(near_sheet), {});
  const Scene open(device_, Describe(far_sheet), {});
  for (int round = 0; round < 3; ++round) {
    ExpectBlocked(blocked, true);
    ExpectBlocked(open, false);
  }
  auto copied = std::make_unique<Scene>(device_, Describe(far_sheet), SceneOptions{}, blocked);
  ASSERT_TRUE(copied->takes_over());
  copied->TakeCopy(blocked);
  ExpectBlocked(blocked, true);
  ExpectBlocked(*copied, false);
  ExpectBlocked(blocked, true);
}

TEST_F(BlockedRaysTest, RaysThatEndBeforeAreNotBlocked) {
  const Sheet sheet = MakeSheet(0);
  const Scene scene(device_, Describe(sheet), {});
  for (int i = 0; i < 400; ++i) {
    Ray ray;
    ray.org[0] = 0.51f;
    ray.org[1] = 0.53f;
    ray.org[2] = -2;
    ray.dir[2] = 1;
    const int what = i % 5;
    if (what == 1) ray.tfar = 1.9f;
    if (what == 2) ray.tnear = 2.1f;
    if (what == 3) ray.dir[2] = -1;
    if (what == 4) ray.org[0] = unit::kNaN;
    ASSERT_EQ(scene.AnyHit(ray), what == 0) << i;
  }
}

}  // namespace
}  // namespace dacrt
