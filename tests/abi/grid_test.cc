// Grids that reach beyond their vertices, beside the real library.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

/// A committed scene of one grid over `vertices` vertices, which stand in rows of four.
RTCScene SceneOfGrid(Session& s, const RTCGrid& grid, std::size_t vertices) {
  const RTCGeometry geometry = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_GRID));
  auto* const vertex = static_cast<float*>(s.api.rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices));
  for (std::size_t i = 0; i < vertices; ++i) {
    vertex[3 * i] = static_cast<float>(i % 4);
    vertex[3 * i + 1] = static_cast<float>(i / 4);
    vertex[3 * i + 2] = 0;
  }
  *static_cast<RTCGrid*>(s.api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0,
                                                       RTC_FORMAT_GRID, sizeof(RTCGrid), 1)) = grid;
  s.api.rtcCommitGeometry(geometry);
  return s.SceneOf(geometry);
}

/// Which of the nine cells of 4 x 4 vertices are hit, a '#' each, by rows.
std::string CellsHit(Session& s, RTCScene scene) {
  std::string cells;
  for (int cell = 0; cell < 9; ++cell) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray = RayAt(static_cast<float>(cell % 3) + 0.3f);
    ray.ray.org_y = static_cast<float>(cell / 3) + 0.3f;
    s.api.rtcIntersect1M(scene, &context, &ray, 1, sizeof ray);
    cells += ray.hit.geomID == 0 ? '#' : '.';
  }
  return cells;
}

class Grids : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Grids);

// Up to the last vertex, and not beyond: then nothing of the grid is there.
TEST_P(Grids, OneThatReachesBeyondItsVerticesIsLeftOut) {
  struct Case {
    RTCGrid grid;
    std::size_t vertices;
    const char* cells;
  };
  const Case cases[] = {
      {{0, 4, 4, 4}, 16, "#########"},  {{0, 4, 4, 4}, 17, "#########"},
      {{0, 4, 4, 4}, 15, "........."},  {{0, 4, 4, 4}, 12, "........."},
      {{0, 4, 2, 2}, 6, "#........"},   {{0, 4, 2, 2}, 5, "........."},
      {{5, 4, 3, 3}, 16, "....##.##"},  {{6, 4, 3, 3}, 16, "........."},
      {{8, 4, 4, 2}, 16, "......###"},  {{9, 4, 4, 2}, 16, "........."},
      {{16, 4, 2, 2}, 16, "........."}, {{0xFFFFFFF0u, 4, 4, 4}, 16, "........."},
  };
  for (const Case& c : cases) {
    Session s(GetParam()());
    EXPECT_EQ(CellsHit(s, SceneOfGrid(s, c.grid, c.vertices)), c.cells)
        << c.grid.startVertexID << ", " << c.grid.width << " x " << c.grid.height << " over "
        << c.vertices;
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  }
}

/// The most memory that the device takes at once, from here on.
class LargestTaken {
 public:
  explicit LargestTaken(const Session& s) : session_(s) {
    s.api.rtcSetDeviceMemoryMonitorFunction(
        s.device,
        [](void* user, ssize_t bytes, bool) {
          auto& largest = *static_cast<ssize_t*>(user);
          largest = std::max(largest, bytes);
          return true;
        },
        &bytes_);
  }
  ~LargestTaken() {
    session_.api.rtcSetDeviceMemoryMonitorFunction(session_.device, nullptr, nullptr);
  }
  LargestTaken(const LargestTaken&) = delete;
  LargestTaken& operator=(const LargestTaken&) = delete;

  ssize_t bytes() const { return bytes_; }

 private:
  const Session& session_;
  ssize_t bytes_ = 0;
};

// Its cells were checked one after the other, and room was made for each: 8 GB for a buffer of 12
// bytes.
TEST(DropInGrids, TheLargestOverAFewVerticesTakesNoMemory) {
  Session s(DropIn());
  const LargestTaken most(s);
  const RTCScene scene = SceneOfGrid(s, {0, 4, 32767, 32767}, 16);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(CellsHit(s, scene), ".........");
  EXPECT_LT(most.bytes(), 4 << 20);
}

// All rows of a grid without a stride are one: over 32767 vertices it asked for a billion cells,
// none of which has an area.
TEST(DropInGrids, OneWithoutAStrideHasOneRowOfCells) {
  Session s(DropIn());
  const LargestTaken most(s);
  const RTCScene scene = SceneOfGrid(s, {0, 0, 32767, 32767}, 32767);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(CellsHit(s, scene), ".........");
  EXPECT_LT(most.bytes(), 8 << 20);
  RTCBounds bounds;
  s.api.rtcGetSceneBounds(scene, &bounds);
  EXPECT_EQ(bounds.upper_x, 3);
  EXPECT_EQ(bounds.upper_y, 32766 / 4);
}

TEST_P(Grids, WithoutAStrideAreNeverHit) {
  Session s(GetParam()());
  const RTCScene scene = SceneOfGrid(s, {0, 0, 4, 4}, 16);
  EXPECT_EQ(CellsHit(s, scene), ".........");
  RTCBounds bounds;
  s.api.rtcGetSceneBounds(scene, &bounds);
  EXPECT_EQ(bounds.lower_x, 0);
  EXPECT_EQ(bounds.upper_x, 3);
  EXPECT_EQ(bounds.upper_y, 0);
}

// What the program writes to the grid between two commits is not there yet; it ended the process
// where a grid of a width of 1 was divided into its columns.
TEST(DropInGrids, OneWhoseSizeIsWrittenBetweenCommitsDoesNoHarm) {
  Session s(DropIn());
  RTCGrid grid = {0, 4, 4, 4};
  const RTCGeometry geometry = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_GRID));
  std::vector<float> vertices(3 * 20);
  for (std::size_t i = 0; i < 16; ++i) {
    vertices[3 * i] = static_cast<float>(i % 4);
    vertices[3 * i + 1] = static_cast<float>(i / 4);
  }
  s.api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   vertices.data(), 0, 12, 16);
  s.api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, &grid, 0,
                                   sizeof(RTCGrid), 1);
  s.api.rtcCommitGeometry(geometry);
  const RTCScene scene = s.SceneOf(geometry);
  for (const RTCGrid& other : {RTCGrid{0, 4, 1, 1}, RTCGrid{0, 4, 0, 0}, RTCGrid{9, 9, 9, 9}}) {
    grid = other;
    CellsHit(s, scene);
  }
  grid = {0, 4, 4, 4};
  s.api.rtcCommitGeometry(geometry);
  s.api.rtcCommitScene(scene);
  EXPECT_EQ(CellsHit(s, scene), "#########");
}

}  // namespace
}  // namespace dacrt::tests
