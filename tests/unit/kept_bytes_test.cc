// What scenes of all shapes keep, through the public API.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "leaf/leaf_block.h"
#include "shape_scenes.h"
#include "trace/policy.h"

namespace dacrt::unit {
namespace {

/// A sheet of so many squares to a side, at one or more times, of triangles, quads, or one grid.
Geometry MakeSheet(Shape shape, std::size_t side, std::size_t steps, Model& sheet) {
  const std::size_t row = side + 1;
  sheet.steps.resize(steps);
  for (std::size_t step = 0; step < steps; ++step) {
    for (std::size_t i = 0; i < row * row; ++i) {
      const auto x = static_cast<float>(i % row), y = static_cast<float>(i / row);
      for (const float value :
           {x, y, 3 * std::sin(0.1f * x + 0.2f * y) + static_cast<float>(step)}) {
        sheet.steps[step].push_back(value);
      }
    }
  }
  for (std::size_t i = 0; i < side * side; ++i) {
    const auto corner = static_cast<uint32_t>(i / side * row + i % side);
    const auto above = static_cast<uint32_t>(corner + row);
    if (shape == Shape::kQuads) {
      sheet.indices.insert(sheet.indices.end(), {corner, corner + 1, above + 1, above});
    } else {
      sheet.indices.insert(sheet.indices.end(),
                           {corner, corner + 1, above + 1, corner, above + 1, above});
    }
  }
  Geometry view = sheet.View(3);
  view.shape = shape;
  if (shape == Shape::kGrids) {
    sheet.grids = {
        {0, static_cast<uint32_t>(row), static_cast<uint16_t>(row), static_cast<uint16_t>(row)}};
    view.primitives = {sheet.grids.data(), sizeof(GridPrimitive)};
    view.primitive_count = 1;
  } else {
    const std::size_t corners = shape == Shape::kQuads ? 4 : 3;
    view.primitives = {sheet.indices.data(), corners * sizeof(uint32_t)};
    view.primitive_count = sheet.indices.size() / corners;
  }
  return view;
}

/// `count` rays a side down onto a sheet.
std::vector<TimedRay> RaysDown(std::size_t count, float apart) {
  std::vector<TimedRay> rays(count * count);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i].org = {apart * static_cast<float>(i % count) + 0.2f,
                   apart * static_cast<float>(i / count) + 0.1f, 100};
    rays[i].dir = {0, 0, -1};
  }
  return rays;
}

// In short calls, which go the same way in each scene: longer ones learn which way is quicker, and
// what lies behind a hit is reached by one and not by the other.
std::vector<TimedRay> TraceInShortCalls(const Scene& scene, const std::vector<TimedRay>& rays) {
  constexpr std::size_t kCall = 250;
  std::vector<TimedRay> answers;
  for (std::size_t begin = 0; begin < rays.size(); begin += kCall) {
    const std::size_t end = std::min(rays.size(), begin + kCall);
    const auto some = Trace(scene, {rays.data() + begin, rays.data() + end});
    answers.insert(answers.end(), some.begin(), some.end());
  }
  return answers;
}

// Of whatever shape a mesh is, moving or not, the default budget holds nearly all that rays can ask
// for, and no leaf goes without a copy while there is room; split with care or without.
TEST(KeptBytesTest, TheDefaultBudgetHoldsMeshesOfEveryShape) {
  constexpr std::size_t kSide = 360;  // beyond what is kept without regard to the share of each
  const std::vector<TimedRay> rays = RaysDown(2 * kSide, 0.5f);
  for (const Shape shape : {Shape::kTriangles, Shape::kQuads, Shape::kGrids}) {
    for (const std::size_t steps : {1u, 2u, 3u, 9u}) {
      Model sheet;
      const Geometry geometry = MakeSheet(shape, kSide, steps, sheet);
      const auto by_default = MakeScene({geometry}, kDefaultBudget, false, 1);
      const auto unlimited = MakeScene({geometry}, kUnlimitedBudget, false, 1);
      const auto with_care =
          std::make_shared<Scene>(std::make_shared<Device>(Settings{.threads = 1}),
                                  std::vector{geometry}, SceneOptions{.splits_with_care = true});
      const std::string what =
          std::to_string(static_cast<int>(shape)) + " x " + std::to_string(steps);
      const auto answers = TraceInShortCalls(*by_default, rays);
      ExpectSameRays(TraceInShortCalls(*unlimited, rays), answers, what + " without limit");
      ExpectSameRays(TraceInShortCalls(*with_care, rays), answers, what + " with care");
      const std::size_t used = by_default->KeptBytesUsed(), most = unlimited->KeptBytesUsed();
      // Without limit all nodes are exact.
      EXPECT_GE(6 * used, 5 * most) << what;
      EXPECT_LT(with_care->KeptBytesUsed(), used) << what << ": leaves that are fuller take less";
      EXPECT_GE(used, std::min(most, by_default->KeptBytes() / 100 * 99)) << what;
      EXPECT_LT(by_default->KeptBytes(), unlimited->KeptBytes()) << what;
      if (shape == Shape::kTriangles && steps == 1) {
        EXPECT_LE(by_default->KeptBytes(), 32 * 2 * kSide * kSide);
      }
    }
  }
}

// To load vertices as they lie is quicker than to look them up: some memory more for few triangles,
// unless the program's budget is less.
TEST(KeptBytesTest, LeavesOfFewTrianglesRepeatVerticesWhereThereIsRoom) {
  constexpr std::size_t kFew = 88, kMore = 92;  // 15,488 and 16,928 triangles
  const auto bytes_a_triangle = [](std::size_t side, uint64_t budget) {
    Model sheet;
    const auto scene = MakeScene({MakeSheet(Shape::kTriangles, side, 1, sheet)}, budget, false, 1);
    Trace(*scene, RaysDown(2 * side, 0.5f));
    return static_cast<double>(scene->KeptBytesUsed()) / static_cast<double>(2 * side * side);
  };
  const double sharing = bytes_a_triangle(kMore, kDefaultBudget);
  EXPECT_GT(bytes_a_triangle(kFew, kDefaultBudget), 1.3 * sharing);
  EXPECT_LT(bytes_a_triangle(kFew, 60 * 2 * kFew * kFew), 1.1 * sharing);
}

// A mesh of a few thousand triangles is no burden, even if they share no vertices.
TEST(KeptBytesTest, TheDefaultBudgetHoldsAllOfSmallMeshes) {
  constexpr std::size_t kSide = 100, kTriangles = 2 * kSide * kSide;
  Model shared, sheet;
  MakeSheet(Shape::kTriangles, kSide, 1, shared);
  sheet.steps.resize(1);
  for (const uint32_t index : shared.indices) {
    sheet.indices.push_back(static_cast<uint32_t>(sheet.indices.size()));
    const float* const vertex = &shared.steps[0][3 * index];
    sheet.steps[0].insert(sheet.steps[0].end(), vertex, vertex + 3);
    sheet.steps[0].back() += 1e-5f * static_cast<float>(sheet.indices.size());
  }
  const Geometry geometry = TriangleView(sheet, 0);
  const std::vector<TimedRay> rays = RaysDown(4 * kSide, 0.25f);
  const auto used = [&](uint64_t budget) {
    const auto scene = MakeScene({geometry}, budget, false, 1);
    TraceInShortCalls(*scene, rays);
    return scene->KeptBytesUsed();
  };
  EXPECT_EQ(used(kDefaultBudget), used(kUnlimitedBudget));
  EXPECT_GT(used(kDefaultBudget), 32 * kTriangles);
  EXPECT_LE(used(32 * kTriangles), 32 * kTriangles);
}

// Whatever its shape, and however many of them there are.
TEST(KeptBytesTest, TheDefaultBudgetHoldsAllOfSmallScenes) {
  constexpr std::size_t kTriangles = 4000;
  Random random(3);
  const Model large = MakeTriangles(random, kTriangles);
  for (const bool are_many : {false, true}) {
    const auto device = std::make_shared<Device>(Settings{.threads = 1});
    // These take the room that there is for prepared leaves.
    std::vector<std::unique_ptr<Scene>> others;
    while (are_many && others.size() * kTriangles <= policy::kPreparedTogether) {
      others.push_back(std::make_unique<Scene>(device, std::vector{TriangleView(large, 0)}));
    }
    const auto check = [&](const Geometry& geometry, const std::vector<TimedRay>& rays,
                           const std::string& what) {
      for (const bool with_care : {false, true}) {
        const Scene scene(device, std::vector{geometry},
                          SceneOptions{.splits_with_care = with_care});
        TraceInShortCalls(scene, rays);
        TraceInShortCalls(scene, rays);
        EXPECT_LE(scene.KeptBytesUsed() + kMostLeafBytes, scene.KeptBytes())
            << what << (are_many ? " of many" : "");
      }
    };
    for (const std::size_t side : {1u, 2u, 4u, 11u, 30u}) {
      for (const Shape shape : {Shape::kTriangles, Shape::kQuads, Shape::kGrids}) {
        for (const std::size_t steps : {1u, 2u, 9u}) {
          Model sheet;
          const Geometry geometry = MakeSheet(shape, side, steps, sheet);
          std::vector<TimedRay> rays = RaysDown(4 * side, 0.25f);
          check(geometry, rays,
                std::to_string(side) + ": " + std::to_string(static_cast<int>(shape)) + " x " +
                    std::to_string(steps));
        }
      }
    }
    for (const std::size_t triangles : {1u, 9u, 36u, 300u, 1000u}) {
      Random chance(4);
      const Model soup = MakeTriangles(chance, triangles);
      std::vector<TimedRay> rays(3000);
      for (TimedRay& ray : rays) {
        ray.org = chance.InCube(-3, 3);
        ray.dir = chance.InCube(-1, 1);
      }
      check(TriangleView(soup, 0), rays, std::to_string(triangles) + " that overlap");
    }
  }
}

// Most of what a few may take would lie idle in each of many.
TEST(KeptBytesTest, SmallScenesOfManyTakeLittle) {
  const auto device = std::make_shared<Device>(Settings{.threads = 1});
  Random random(5);
  const Model model = MakeTriangles(random, 300);
  std::vector<std::unique_ptr<Scene>> scenes;
  while (scenes.size() < 50) {
    scenes.push_back(std::make_unique<Scene>(device, std::vector{TriangleView(model, 0)}));
  }
  EXPECT_GT(scenes.front()->KeptBytes(), 192u * 300);
  EXPECT_LT(scenes.back()->KeptBytes(), 90u * 300);
}

}  // namespace
}  // namespace dacrt::unit
