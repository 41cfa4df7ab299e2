// The kinds of geometry: both libraries take them, and find the same hits.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "committed_scene.h"
#include "errors.h"
#include "geometry_kind.h"
#include "hit_shares.h"
#include "mesh_cut.h"
#include "mesh_shapes.h"
#include "ray_kind.h"
#include "room.h"
#include "wave.h"

namespace dacrt::bench {
namespace {

class GeometryTest : public testing::TestWithParam<const char*> {};

TEST_P(GeometryTest, BothLibrariesFindTheSameHits) {
  const BenchScene hall = SceneSource("hall-75k", "").LoadForEmbree();
  const SceneContent content = FindGeometryKind(GetParam())->make(hall);
  const EmbreeLibrary embree(DACRT_REAL_EMBREE, "threads=1");
  const EmbreeLibrary drop_in(DACRT_DROP_IN, "threads=1");
  const CommittedScene real(embree, content, Build::kMedium);
  const CommittedScene high(embree, content, Build::kHigh);
  const CommittedScene dynamic(embree, content, Build::kLowDynamic);
  const CommittedScene dacrt(drop_in, content, Build::kMedium);
  EXPECT_GT(real.commit_seconds(), 0);
  RaySource source(hall, content.needs);
  const auto trace = [&](RayBuffer& rays) {
    real.Trace(Query::kClosest, kIncoherentStream, rays.rays());
  };
  for (const char* const name : {"primary", "ambient", "diffuse"}) {
    const RayKind& kind = *FindRayKind(name);
    RayBuffer rays = source.Make(kind, 64, trace);
    real.Trace(kind.query, kIncoherentStream, rays.rays());
    const HitShares hits(kind.query, rays);
    EXPECT_GT(hits.hits(), 0.05) << name;
    for (const auto& [scene, which] :
         {std::pair(&high, "high"), std::pair(&dynamic, "dynamic"), std::pair(&dacrt, "dacrt")}) {
      rays.Rearm();
      scene->Trace(kind.query, kIncoherentStream, rays.rays());
      EXPECT_NO_THROW(hits.Check(rays)) << name << ", " << which;
    }
  }
}

std::vector<const char*> KindNames() {
  std::vector<const char*> names;
  for (const GeometryKind& kind : GeometryKinds()) names.push_back(kind.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Kinds, GeometryTest, testing::ValuesIn(KindNames()),
                         [](const testing::TestParamInfo<const char*>& info) {
                           std::string name = info.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(MeshCutTest, PartsHaveEveryTriangleOnce) {
  const BenchScene room = Room();
  for (const std::size_t count : {1, 5, 12, 100}) {
    SceneContent content;
    CutIntoParts(room.mesh, count, content);
    EXPECT_EQ(content.geometries.size(), std::min<std::size_t>(count, 12));
    std::vector<float> corners, expected;
    for (const GeometryContent& part : content.geometries) {
      for (std::size_t i = 0; i < 3 * part.primitive_count; ++i) {
        EXPECT_LT(part.primitives[i], part.vertex_count);
        corners.push_back(part.vertices[0][3 * part.primitives[i]]);
      }
    }
    for (const uint32_t index : room.mesh.indices) {
      expected.push_back(room.mesh.positions[3 * index]);
    }
    EXPECT_EQ(corners, expected);
  }
}

TEST(MeshShapesTest, NeighboursArePairedAlongTheirEdge) {
  const std::vector<uint32_t> pair = {0, 1, 2, 0, 2, 3};
  ASSERT_EQ(PairTriangles(pair).size(), 1u);
  const QuadCorners quad = PairTriangles(pair).front();
  EXPECT_EQ(std::set<uint32_t>(quad.begin(), quad.end()), (std::set<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ((std::set<uint32_t>{quad[1], quad[3]}), (std::set<uint32_t>{0, 2})) << "the diagonal";
  EXPECT_EQ(PairTriangles({0, 1, 2, 3, 4, 5}).size(), 2u) << "no edge in common";
  EXPECT_EQ(PairTriangles({0, 1, 2, 0, 1, 3}).size(), 2u) << "the edge has the same direction";
  EXPECT_EQ(PairTriangles({0, 1, 2}).front(), (QuadCorners{0, 1, 2, 2}));
}

TEST(MeshShapesTest, CellsInRowsBecomeOneGrid) {
  // Three by two cells of a plane, and a quad with other numbers.
  BenchScene scene{};
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x)
      scene.mesh.positions.insert(scene.mesh.positions.end(), {x * 1.f, y * 1.f, 0});
  }
  for (uint32_t y = 0; y < 2; ++y) {
    for (uint32_t x = 0; x < 3; ++x) {
      const uint32_t low = 4 * y + x, high = low + 4;
      scene.mesh.indices.insert(scene.mesh.indices.end(),
                                {low, low + 1, high + 1, low, high + 1, high});
    }
  }
  scene.mesh.indices.insert(scene.mesh.indices.end(), {0, 3, 11, 0, 11, 8});
  const SceneContent content = Grids(scene);
  const GeometryContent& grids = content.geometries.front();
  ASSERT_EQ(grids.primitive_count, 2u);
  const auto* const grid = reinterpret_cast<const RTCGrid*>(grids.primitives);
  EXPECT_EQ(grid[0].startVertexID, 0u);
  EXPECT_EQ(grid[0].stride, 4u);
  EXPECT_EQ(grid[0].width, 4u);
  EXPECT_EQ(grid[0].height, 3u);
  EXPECT_EQ(grid[1].startVertexID, 12u) << "with vertices of its own";
  EXPECT_EQ(grids.vertex_count, 16u);
}

TEST(WaveTest, MovesEveryVertexALittleAndComesBack) {
  const BenchScene room = Room();
  const Wave wave(room.mesh);
  std::vector<float> moved = room.mesh.positions, back = moved;
  wave.Apply(0.25f, 0, moved);
  EXPECT_NE(moved, room.mesh.positions);
  const float diagonal = Bounds(room.mesh).size().length();
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_NEAR(moved[i], room.mesh.positions[i], 0.01f * diagonal);
  }
  wave.Apply(1.25f, 0, back);
  for (std::size_t i = 0; i < moved.size(); ++i) EXPECT_NEAR(moved[i], back[i], 1e-4f);
}

TEST(HitSharesTest, DifferentHitsAreNoticed) {
  RayBuffer rays(4000);
  rays.Begin(kInfinity);
  for (int i = 0; i < 4000; ++i) rays.Append({0, 0, 0}, {0, 0, 1}, i);
  for (RayRecord& ray : rays.rays()) {
    ray.tfar = 2;
    ray.geometry_id = 0;
  }
  const HitShares hits(Query::kClosest, rays);
  EXPECT_EQ(hits.hits(), 1);
  EXPECT_EQ(hits.Equal(rays), 1);
  rays.rays()[0].tfar = 2.0001f;
  rays.rays()[1].geometry_id = kNoGeometry;
  EXPECT_DOUBLE_EQ(hits.Equal(rays), 3999.0 / 4000);
  EXPECT_NO_THROW(hits.Check(rays));
  for (int i = 1; i < 10; ++i) rays.rays()[i].tfar = 2.1f;
  EXPECT_THROW(hits.Check(rays), Disagreement);
}

TEST(SceneSourceTest, HallsOfAnySizeAndTheBoxAreGenerated) {
  EXPECT_NEAR(SceneSource("hall-100k", "").Load().TriangleCount(), 100'000, 10'000);
  EXPECT_EQ(SceneSource("box-36", "").Load().TriangleCount(), 36u);
  for (const char* const name : {"hall-", "hall-many", "hall-3x", "hall-0", "box-37"}) {
    EXPECT_FALSE(SceneSource(name, "").IsGenerated()) << name;
  }
}

}  // namespace
}  // namespace dacrt::bench
