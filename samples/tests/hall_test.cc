// The generated hall: its size, its soundness, and that it is the same everywhere.
#include "scenes/hall.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace {

using scenes::MakeHall;
using scenes::Mesh;

// FNV-1a over the bits of positions and indices.
uint64_t Fingerprint(const Mesh& mesh) {
  uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](uint32_t word) { hash = (hash ^ word) * 0x100000001b3; };
  for (float position : mesh.positions) add(std::bit_cast<uint32_t>(position));
  for (uint32_t index : mesh.indices) add(index);
  return hash;
}

bool IsDegenerate(const Mesh& mesh, size_t triangle) {
  const uint32_t* corners = &mesh.indices[3 * triangle];
  double edges[2][3];
  for (int axis = 0; axis < 3; ++axis) {
    const double first = mesh.positions[3 * corners[0] + axis];
    for (int edge = 0; edge < 2; ++edge) {
      edges[edge][axis] = mesh.positions[3 * corners[edge + 1] + axis] - first;
    }
  }
  const auto& [a, b] = edges;
  return a[1] * b[2] == a[2] * b[1] && a[2] * b[0] == a[0] * b[2] && a[0] * b[1] == a[1] * b[0];
}

class HallOfSize : public testing::TestWithParam<uint32_t> {};

TEST_P(HallOfSize, HasAboutTheTrianglesAskedFor) {
  const double triangles = double(MakeHall(GetParam()).TriangleCount());
  EXPECT_NEAR(triangles / GetParam(), 1.0, 0.1);
}

TEST_P(HallOfSize, IsSound) {
  const Mesh mesh = MakeHall(GetParam());
  EXPECT_TRUE(std::all_of(mesh.positions.begin(), mesh.positions.end(),
                          [](float position) { return std::isfinite(position); }));
  ASSERT_TRUE(std::all_of(mesh.indices.begin(), mesh.indices.end(),
                          [&](uint32_t index) { return index < mesh.VertexCount(); }));
  size_t degenerate = 0;
  for (size_t i = 0; i < mesh.TriangleCount(); ++i) degenerate += IsDegenerate(mesh, i);
  EXPECT_EQ(degenerate, 0u);
}

INSTANTIATE_TEST_SUITE_P(Hall, HallOfSize,
                         testing::Values(75'000, 100'000, 150'000, 260'000, 400'000, 1'000'000,
                                         5'000'000));

TEST(Hall, TakesTheNearerEndOfTheRangeForNumbersOutsideOfIt) {
  EXPECT_EQ(MakeHall(1).TriangleCount(), MakeHall(scenes::kHallLeastTriangles).TriangleCount());
}

// Measured figures and pictures are only worth comparing while this holds: whoever changes the hall
// on purpose changes the number.
TEST(Hall, IsTheSameOnEveryMachine) { EXPECT_EQ(Fingerprint(MakeHall()), 16915823094755696216u); }

}  // namespace
