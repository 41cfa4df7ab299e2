// Scene::Trace and its callers: bad input, threads, and scenes that calls leave as they are.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "trace/policy.h"
#include "trace_scene.h"

namespace dacrt {
namespace {

using unit::ExpectBlockedWhereHit;
using unit::ExpectSameRays;
using unit::MakeLargeMeshes;
using unit::MakeMeshes;
using unit::MakeMixedRays;
using unit::Random;
using unit::Ray;
using unit::TestScene;
using unit::VariedBudgets;

TEST(TraceCallTest, BadInputThrowsAndChangesNothing) {
  Random random(14);
  const TestScene scene(MakeMeshes(random), Settings());
  auto rays = unit::MakeRays(random, 10, 3);
  const auto before = rays;
  for (RayView::Component RayView::*component :
       {&RayView::org_x, &RayView::org_y, &RayView::org_z, &RayView::dir_x, &RayView::dir_y,
        &RayView::dir_z, &RayView::tfar}) {
    RayView view = ViewOf(rays);
    view.*component = RayView::kAbsent;
    EXPECT_THROW((*scene).Trace(Query::kClosest, view), std::invalid_argument);
    EXPECT_THROW((*scene).Trace(Query::kAny, view), std::invalid_argument);
    view.count = 0;
    EXPECT_THROW((*scene).Trace(Query::kAny, view), std::invalid_argument);
  }
  RayView view = ViewOf(rays);
  view.lanes = 0;
  EXPECT_THROW((*scene).Trace(Query::kClosest, view), std::invalid_argument);
  ExpectSameRays(rays, before, "refused");
}

TEST(TraceCallTest, ThreadsThatShareASceneGetTheSameBits) {
  Random random(15);
  Settings settings;
  settings.piece_rays = 700;
  const TestScene scene(MakeMeshes(random), settings);
  const auto before = MakeMixedRays(random, 2000);
  const auto expected = scene.Traced(before);
  constexpr std::size_t kThreads = 6;
  std::vector<std::vector<Ray>> rays(kThreads, before);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int round = 0; round < 10; ++round) {
        rays[t] = before;
        scene.Trace(rays[t]);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& traced : rays) ExpectSameRays(traced, expected, "a thread");
}

// Threads that trace a scene to which nobody came before split its subsets side by side.
TEST(TraceCallTest, ThreadsThatComeToAFreshSceneGetTheSameBits) {
  Random random(21);
  const auto meshes = MakeLargeMeshes(random);
  const std::size_t triangles = meshes[0].triangles.size() + meshes[1].triangles.size();
  Settings nothing;
  nothing.budget = 0;
  const auto before = MakeMixedRays(random, 3000);
  const auto expected = TestScene(meshes, nothing).Traced(before);
  for (const uint64_t budget : VariedBudgets(triangles)) {
    for (const uint32_t workers : {1u, 3u}) {
      for (int round = 0; round < 4; ++round) {
        Settings settings;
        settings.budget = budget;
        settings.threads = workers;
        const TestScene scene(meshes, settings);
        constexpr std::size_t kThreads = 4;
        std::vector<std::vector<Ray>> rays(kThreads, before);
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < kThreads; ++t) {
          threads.emplace_back(
              [&, t] { scene.Trace(rays[t], t % 4 == 3 ? Query::kAny : Query::kClosest); });
        }
        for (std::thread& thread : threads) thread.join();
        for (std::size_t t = 0; t < kThreads; ++t) {
          if (t % 4 == 3) {
            ExpectBlockedWhereHit(rays[t], before, expected);
          } else {
            ExpectSameRays(rays[t], expected, "thread " + std::to_string(t));
          }
        }
        if (HasFatalFailure()) return;
      }
    }
  }
}

// The same scene, traced from the caller's vertices each time.
TEST(TraceCallTest, CallsDoNotChangeTheScene) {
  Random random(16);
  const TestScene scene(MakeMeshes(random), Settings());
  const auto before = MakeMixedRays(random, 500);
  const auto expected = scene.Traced(before);
  for (int i = 0; i < 3; ++i) {
    scene.Traced(unit::MakeRays(random, 1000, 3), Query::kAny);
    ExpectSameRays(scene.Traced(before), expected, "again");
  }
}

}  // namespace
}  // namespace dacrt
