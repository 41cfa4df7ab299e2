// The rays that are measured.
#include "frame.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "errors.h"
#include "hit_check.h"
#include "measure.h"
#include "room.h"

namespace dacrt::bench {
namespace {

struct TracedPass {
  Pass pass;
  std::vector<RayRecord> rays;  // before they were traced
};

std::vector<TracedPass> TraceRoom(const FrameKind& kind) {
  const BenchScene room = Room();
  const TriangleMesh mesh = room.AsTriangleMesh();
  const Scene scene(std::make_shared<Device>(), std::span(&mesh, 1));
  std::vector<TracedPass> passes;
  constexpr uint32_t kSide = 128;
  TraceFrame(kind, room, Raster(kSide), [&](const Pass& pass, RayBuffer& rays) {
    passes.push_back({pass, {rays.rays().begin(), rays.rays().end()}});
    scene.Trace(pass.query, rays.View());
  });
  return passes;
}

TEST(FrameTest, EveryKindSendsItsPasses) {
  const std::vector<std::vector<std::string>> kNames = {
      {"primary", "primary, shadow", "reflection", "reflection, shadow"},
      {"primary", "primary, shadow", "reflection", "reflection, shadow"},
      {"primary", "primary, ambient occlusion"},
      {"primary", "primary, shadow", "bounce 1", "bounce 1, shadow", "bounce 2", "bounce 2, shadow",
       "bounce 3", "bounce 3, shadow"},
      {"primary", "primary, shadow", "bounce 1", "bounce 1, shadow", "bounce 2", "bounce 2, shadow",
       "bounce 3", "bounce 3, shadow"},
  };
  ASSERT_EQ(FrameKinds().size(), kNames.size());
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    std::vector<std::string> names;
    for (const TracedPass& pass : TraceRoom(FrameKinds()[i])) names.push_back(pass.pass.name);
    EXPECT_EQ(names, kNames[i]) << FrameKinds()[i].name;
  }
}

// In a closed room with nothing in it every ray hits a wall, and none is in shadow.
TEST(FrameTest, RaysStartOffTheSurfaceAndOnItsRightSide) {
  for (const FrameKind& kind : FrameKinds()) {
    const BenchScene room = Room();
    Contest contest(room, {{"nabata2013", {}}});
    const FrameResult result =
        contest.Measure(kind, Raster(256), 1, [](const Pass&, std::size_t) {});
    for (const PassResult& pass : result.passes) {
      const Statistics& statistics = pass.by_method[0].Median().statistics;
      EXPECT_EQ(statistics.rays, pass.rays) << kind.name << ", " << pass.pass.name;
      if (pass.pass.query == Query::kClosest) {
        // Less those that slip through an edge: the test of a triangle is not watertight.
        EXPECT_GE(statistics.hits + 2, pass.rays) << kind.name << ", " << pass.pass.name;
      } else if (kind.occlusion != Occlusion::kAmbient) {
        EXPECT_EQ(statistics.hits, 0u) << kind.name << ", " << pass.pass.name;
      }
    }
  }
}

TEST(FrameTest, ShadowRaysOfThePointLightShareTheirOrigin) {
  const std::vector<TracedPass> passes = TraceRoom(FrameKinds()[0]);
  std::set<std::array<float, 3>> origins;
  for (const RayRecord& ray : passes[1].rays) {
    origins.insert({ray.org[0], ray.org[1], ray.org[2]});
  }
  EXPECT_EQ(origins.size(), 1u);
}

TEST(FrameTest, TheSameFrameHasTheSameRays) {
  for (const FrameKind& kind : FrameKinds()) {
    const std::vector<TracedPass> first = TraceRoom(kind);
    const std::vector<TracedPass> second = TraceRoom(kind);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      ASSERT_EQ(first[i].rays.size(), second[i].rays.size());
      for (std::size_t j = 0; j < first[i].rays.size(); ++j) {
        const RayRecord& a = first[i].rays[j];
        const RayRecord& b = second[i].rays[j];
        ASSERT_EQ(a.id, b.id);
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_EQ(a.org[axis], b.org[axis]);
          ASSERT_EQ(a.dir[axis], b.dir[axis]);
        }
      }
    }
  }
}

TEST(RasterTest, MoreRaysAreMoreSamples) {
  EXPECT_EQ(Raster(4096).pixels_a_side(), 512u);
  EXPECT_EQ(Raster(4096).samples_a_side(), 8u);
  EXPECT_EQ(Raster(300).pixels_a_side(), 300u);
  EXPECT_EQ(Raster(300).RayCount(), 90'000u);
  EXPECT_THROW(Raster(0), UsageError);
  EXPECT_THROW(Raster(700), UsageError);
  EXPECT_THROW(Raster(16'384), UsageError);
}

TEST(RunsTest, MedianOfAnEvenNumberIsTheFasterInTheMiddle) {
  const Runs runs{{{4, {}}, {1, {}}, {3, {}}, {2, {}}}};
  EXPECT_EQ(runs.Median().seconds, 2);
  EXPECT_EQ(runs.LeastSeconds(), 1);
}

TEST(FingerprintTest, SeesEveryBitOfAHitAndNothingElse) {
  RayRecord miss{};
  miss.geometry_id = kNoGeometry;
  RayRecord other_miss = miss;
  other_miss.u = 1;
  EXPECT_EQ(Fingerprint(Query::kClosest, miss), Fingerprint(Query::kClosest, other_miss));
  RayRecord hit{};
  RayRecord other_hit = hit;
  other_hit.v = std::nextafter(0.0f, 1.0f);
  EXPECT_NE(Fingerprint(Query::kClosest, hit), Fingerprint(Query::kClosest, miss));
  EXPECT_NE(Fingerprint(Query::kClosest, hit), Fingerprint(Query::kClosest, other_hit));
}

TEST(HitCheckTest, OneOtherHitIsADisagreement) {
  RayBuffer rays(3);
  rays.Begin(kInfinity);
  for (uint32_t id = 0; id < 3; ++id) rays.Append({0, 0, 0}, {0, 0, 1}, id);
  HitCheck check(Query::kClosest);
  rays.rays()[1].geometry_id = 0;
  rays.rays()[1].tfar = 2;
  check.Check("one", rays);
  check.Check("another", rays);
  rays.rays()[1].tfar = std::nextafter(2.0f, 3.0f);
  try {
    check.Check("a third", rays);
    FAIL() << "no disagreement";
  } catch (const Disagreement& error) {
    const std::string message = error.what();
    for (const char* const part : {"one", "a third", "1 of 3 rays", "ray 1 "}) {
      EXPECT_NE(message.find(part), std::string::npos) << message;
    }
  }
}

TEST(RayBufferTest, RearmingUndoesATrace) {
  RayBuffer rays(1);
  rays.Begin(1);
  rays.Append({0, 0, 0}, {0, 0, 1}, 7);
  rays.rays()[0].tfar = -kInfinity;
  rays.rays()[0].geometry_id = 0;
  rays.Rearm();
  EXPECT_EQ(rays.rays()[0].tfar, 1);
  EXPECT_EQ(rays.rays()[0].geometry_id, kNoGeometry);
  EXPECT_EQ(rays.rays()[0].id, 7u);
}

}  // namespace
}  // namespace dacrt::bench
