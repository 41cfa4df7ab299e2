// Geometries of every shape, for tests of what is made of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/geometry_table.h"
#include "scene/scene_parts.h"
#include "unit_test.h"

namespace dacrt::unit {

inline constexpr std::size_t kItems = 40;  ///< of each geometry

/// Geometries of every shape, still and moving, over one array of vertices each.
class AllShapes {
 public:
  explicit AllShapes(uint64_t seed) {
    Random random(seed);
    for (std::size_t i = 0; i < 4 * kItems; ++i) {
      const Float3 v = random.InCube(-1, 1);
      for (std::size_t step = 0; step < kMostSteps; ++step) {
        for (const float value : v) {
          corners_[step].push_back(value * (1 + 0.125f * static_cast<float>(step)));
        }
      }
      const Float3 p = random.InCube(-1, 1), n = random.Direction();
      points_.insert(points_.end(), {p[0], p[1], p[2], random.Uniform(0.1f, 1)});
      normals_.insert(normals_.end(), n.begin(), n.end());
      indices_.push_back(static_cast<uint32_t>(i));
    }
    // One grid of 41 x 2 vertices has 40 cells.
    grids_ = {{0, kItems + 1, kItems + 1, 2}};
    inner_.bounds = Box{{-1, -1, -1, 0}, {1, 1, 1, 0}};
  }

  /// Time steps in which facets stand elsewhere.
  static constexpr uint32_t kMostSteps = 10;

  /// The geometry number `id` of the table.
  Geometry Make(Shape shape, uint32_t id, bool moves) const {
    return MakeInSteps(shape, id, moves ? 2 : 1);
  }
  Geometry MakeInSteps(Shape shape, uint32_t id, uint32_t steps) const {
    Geometry geometry;
    geometry.shape = shape;
    geometry.geometry_id = id;
    const bool is_point =
        shape == Shape::kSpheres || shape == Shape::kDiscs || shape == Shape::kOrientedDiscs;
    const std::size_t floats = is_point ? 4 : 3;
    geometry.vertex_count = 4 * kItems;
    geometry.primitive_count = kItems;
    for (uint32_t step = 0; step < steps; ++step) {
      geometry.vertices.push_back({is_point ? points_.data() : corners_[step].data(), 4 * floats});
      if (shape == Shape::kOrientedDiscs) geometry.normals.push_back({normals_.data(), 12});
    }
    switch (shape) {
      case Shape::kTriangles:
        geometry.primitives = {indices_.data(), 12};
        break;
      case Shape::kQuads:
        geometry.primitives = {indices_.data(), 16};
        break;
      case Shape::kGrids:
        geometry.primitives = {grids_.data(), sizeof(GridPrimitive)};
        geometry.primitive_count = 1;
        break;
      case Shape::kUser:
        geometry.vertices.clear();
        geometry.bounds.function = [](void*, uint32_t, uint32_t, Bounds& bounds) {
          bounds = {{-1, -1, -1}, {1, 1, 1}};
        };
        geometry.user_time_steps = steps;
        break;
      case Shape::kInstance:
        geometry.vertices.clear();
        geometry.primitive_count = 1;
        geometry.transforms.resize(steps);
        break;
      default:
        break;
    }
    return geometry;
  }

  GeometryTable Table(const std::vector<Geometry>& geometries) const {
    std::vector<const SceneParts*> scenes;
    for (const Geometry& geometry : geometries) {
      scenes.push_back(geometry.shape == Shape::kInstance ? &inner_ : nullptr);
    }
    return GeometryTable(geometries, scenes, false);
  }

  const std::vector<float>& corners() const { return corners_[0]; }
  const std::vector<float>& points() const { return points_; }
  const std::vector<float>& normals() const { return normals_; }

 private:
  std::vector<float> corners_[kMostSteps], points_, normals_;
  std::vector<uint32_t> indices_;
  std::vector<GridPrimitive> grids_;
  SceneParts inner_{GeometryTable(std::span<const TriangleMesh>())};
};

inline constexpr Shape kShapes[] = {Shape::kTriangles, Shape::kQuads,   Shape::kGrids,
                                    Shape::kSpheres,   Shape::kDiscs,   Shape::kOrientedDiscs,
                                    Shape::kUser,      Shape::kInstance};

}  // namespace dacrt::unit
