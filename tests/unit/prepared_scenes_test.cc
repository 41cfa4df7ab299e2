// Small scenes have large leaves, as long as there are few of them.
#include "engine/prepared_scenes.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "shape_scenes.h"

namespace dacrt::unit {
namespace {

TEST(PreparedScenesTest, HaveRoomTogether) {
  PreparedScenes all;
  constexpr std::size_t kLargest = policy::kPreparedScene;
  std::optional<PreparedScenes::Part> first(std::in_place, all, kLargest);
  EXPECT_TRUE(first->has_room());
  const PreparedScenes::Part not_small(all, kLargest + 1), second(all, kLargest - 1);
  EXPECT_TRUE(second.has_room());
  const PreparedScenes::Part third(all, 1);
  EXPECT_TRUE(third.has_room());
  EXPECT_FALSE(PreparedScenes::Part(all, 1).has_room());
  first.reset();
  EXPECT_TRUE(PreparedScenes::Part(all, kLargest).has_room());
}

TEST(PreparedScenesTest, ManySmallScenesHaveSmallLeaves) {
  Random random(9);
  const Model model = MakeTriangles(random, 500);
  // Two threads that come to a leaf at once may both take room for it.
  const auto device = std::make_shared<Device>(Settings{.threads = 1});
  const auto rays = MakeRays(random, 2000);
  std::vector<TimedRay> answers;
  const auto bytes_of = [&](Scene& scene) {
    const auto traced = Trace(scene, rays);
    if (answers.empty()) answers = traced;
    ExpectSameRays(traced, answers, "the same hits");
    return scene.KeptBytesUsed();
  };
  const auto make = [&] { return std::make_unique<Scene>(device, TriangleView(model, 0)); };
  std::vector<std::unique_ptr<Scene>> scenes;
  scenes.push_back(make());
  const std::size_t prepared = bytes_of(*scenes[0]);
  while (scenes.size() < policy::kPreparedTogether / 500) scenes.push_back(make());
  EXPECT_EQ(bytes_of(*scenes.back()), prepared);
  scenes.push_back(make());
  EXPECT_LT(bytes_of(*scenes.back()), prepared / 2);
  scenes.resize(1);
  EXPECT_EQ(bytes_of(*make()), prepared);
}

}  // namespace
}  // namespace dacrt::unit
