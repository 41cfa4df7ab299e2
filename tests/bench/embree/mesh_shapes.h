// A mesh of triangles as other shapes: the same surface, or nearly.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bench_scene.h"
#include "scene_content.h"

namespace dacrt::bench {

/// Corners in order around the face. The diagonal is from the second to the fourth; a triangle has
/// the third one twice.
using QuadCorners = std::array<uint32_t, 4>;

/// Pairs of neighbouring triangles, one after the other, that have an edge in common; a triangle
/// alone where the next has none with it.
std::vector<QuadCorners> PairTriangles(const std::vector<uint32_t>& indices);

/// A quad mesh of these pairs: the same surface.
SceneContent Quads(const BenchScene& scene);

/// Rectangles of these pairs, where the vertices are numbered as those of a grid are, as one grid
/// each; a grid of one cell, with vertices of its own, for each of the others.
SceneContent Grids(const BenchScene& scene);

/// A sphere for each triangle, about its centre, with half of its area or less.
SceneContent Spheres(const BenchScene& scene);

}  // namespace dacrt::bench
