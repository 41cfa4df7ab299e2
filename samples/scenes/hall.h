// A furnished hall: the scene that the sample draws when no mesh is named, and that tests and
// benchmarks measure on.
//
// Three naves under groin vaults, with columns, windows, a staircase, tables laid for a feast,
// bookcases and chandeliers: walls of few large triangles beside grapes of many tiny ones, as in a
// real interior. The mesh is the same, bit for bit, on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scenes {

// Indexed triangles: three floats a vertex, three vertex numbers a triangle. Every index is in
// range, every position finite, and no triangle is degenerate. They face either way.
struct Mesh {
  std::vector<float> positions;
  std::vector<uint32_t> indices;

  size_t VertexCount() const { return positions.size() / 3; }
  size_t TriangleCount() const { return indices.size() / 3; }
};

struct Camera {
  float eye[3];
  float look_at[3];
  float up[3];
  float vertical_fov;  // degrees
};

// The range within which the hall comes out with the number of triangles asked for, give or take
// ten per cent: below it the furniture itself has more triangles, above it vertex numbers run
// out.
inline constexpr uint32_t kHallLeastTriangles = 75'000;
inline constexpr uint32_t kHallMostTriangles = 500'000'000;
inline constexpr uint32_t kHallDefaultTriangles = 260'000;

// Builds the hall, y up, in metres, its floor at y = 0 and its long axis along x. A number outside
// of the range above counts as the nearer end of it.
Mesh MakeHall(uint32_t triangles = kHallDefaultTriangles);

// A view from the entrance, at the height of a standing person, towards the staircase.
Camera HallCamera();

}  // namespace scenes
