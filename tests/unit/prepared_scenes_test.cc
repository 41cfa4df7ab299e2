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

// Whether there is room for prepared leaves changes with what other scenes come and go.
TEST(PreparedScenesTest, AScenesPartitionDoesNotDependOnOthersLater) {
  const auto device = std::make_shared<Device>(Settings{.threads = 1});
  Random random(9);
  const Model small = MakeTriangles(random, 500), large = MakeTriangles(random, 4000);
  const auto rays = MakeRays(random, 2000);
  const auto fill = [&] {
    std::vector<std::unique_ptr<Scene>> others;
    while (others.size() < 3) {
      others.push_back(std::make_unique<Scene>(device, std::vector{TriangleView(large, 0)}));
    }
    return others;
  };
  const std::vector geometries{TriangleView(small, 0)};
  const auto follow = [&](Scene& scene) {
    auto next = std::make_unique<Scene>(device, geometries, SceneOptions(), scene);
    EXPECT_TRUE(next->takes_over());
    next->TakeOver(scene);
    return next;
  };
  auto others = fill();
  auto of_many = std::make_unique<Scene>(device, geometries);
  const auto all_of_many = std::make_unique<Scene>(device, geometries);
  const auto answers = Trace(*all_of_many, rays);
  const std::size_t used = all_of_many->KeptBytesUsed();
  Trace(*of_many, {rays.begin(), rays.begin() + 10});
  others.clear();
  of_many = follow(*of_many);
  ExpectSameRays(Trace(*of_many, rays), answers, "with room for others");
  EXPECT_LT(of_many->KeptBytesUsed(), 1.1 * static_cast<double>(used))
      << "it has no memory for prepared leaves";
  auto of_few = std::make_unique<Scene>(device, geometries);
  Trace(*of_few, rays);
  EXPECT_GT(of_few->KeptBytesUsed(), 2 * used);
  others = fill();
  of_few = follow(*of_few);
  ExpectSameRays(Trace(*of_few, rays), answers, "without room");
}

}  // namespace
}  // namespace dacrt::unit
