#include "every_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "trace/policy.h"
#include "user_spheres.h"

namespace dacrt::unit {
namespace {

using enum PacketComponent;

/// Rejects hits of odd primitives.
void RejectOdd(void*, const CallbackArguments& arguments) {
  const auto* const ids = static_cast<const uint32_t*>(arguments.packet) +
                          static_cast<std::size_t>(kPrimitiveId) * arguments.width;
  for (std::size_t lane = 0; lane < arguments.width; ++lane) {
    if (arguments.valid[lane] && ids[lane] % 2 == 1) arguments.valid[lane] = 0;
  }
}

}  // namespace

/// Geometries of every shape, still, moving, masked and with filter functions, side by side.
class World {
 public:
  World(std::size_t scale, uint64_t seed) : scale_(scale), random_(seed) {}

  /// Geometries over arrays of this object, with numbers from `id` on.
  std::vector<Geometry> Make(uint32_t id, bool has_callbacks) {
    std::vector<Geometry> all;
    const auto add = [&](Geometry geometry) -> Geometry& {
      geometry.geometry_id = id++;
      all.push_back(std::move(geometry));
      return all.back();
    };
    add(Facets(Shape::kTriangles, 20 * scale_, 1));
    add(Facets(Shape::kTriangles, 10 * scale_, 1)).mask = 2;
    add(Facets(Shape::kTriangles, 3 * scale_, 3));
    add(Facets(Shape::kQuads, 5 * scale_, 1));
    add(Facets(Shape::kQuads, 2 * scale_, 2)).mask = 6;
    add(scale_ < 10 ? Grid(8, 4) : Grid(40, 12));
    add(Points(Shape::kSpheres, 4 * scale_, 1));
    add(Points(Shape::kDiscs, 4 * scale_, 1));
    add(Points(Shape::kOrientedDiscs, 4 * scale_, 1));
    add(Points(Shape::kSpheres, scale_, 2)).mask = 4;
    if (!has_callbacks) return all;
    Geometry& filtered = add(Facets(Shape::kTriangles, 4 * scale_, 1));
    filtered.closest_filter = filtered.any_filter = {RejectOdd, nullptr};
    Geometry& filtered_points = add(Points(Shape::kSpheres, scale_, 1));
    filtered_points.closest_filter = filtered_points.any_filter = {RejectOdd, nullptr};
    add(Users(scale_));
    return all;
  }

  static Geometry Instance(uint32_t id, std::shared_ptr<const Scene> scene, float x, float turn,
                           bool moves) {
    Geometry geometry;
    geometry.shape = Shape::kInstance;
    geometry.geometry_id = id;
    geometry.primitive_count = 1;
    geometry.instanced_scene = std::move(scene);
    for (int step = 0; step < (moves ? 2 : 1); ++step) {
      TransformStep transform;
      AffineTransform& m = transform.matrix;
      m.column[0][0] = m.column[1][1] = 0.5f * std::cos(turn);
      m.column[0][1] = 0.5f * std::sin(turn);
      m.column[1][0] = -0.5f * std::sin(turn);
      m.column[2][2] = 0.7f;
      m.column[3][0] = x + static_cast<float>(step);
      geometry.transforms.push_back(transform);
    }
    return geometry;
  }

 private:
  const void* Keep(std::vector<float> floats) {
    floats_.push_back(std::make_unique<std::vector<float>>(std::move(floats)));
    return floats_.back()->data();
  }

  Geometry Facets(Shape shape, std::size_t count, std::size_t steps) {
    const std::size_t corners = shape == Shape::kQuads ? 4 : 3;
    std::vector<float> first;
    std::vector<uint32_t> indices;
    for (std::size_t i = 0; i < count; ++i) {
      const Float3 at = random_.InCube(-2, 2), a = random_.InCube(-0.2f, 0.2f),
                   b = random_.InCube(-0.2f, 0.2f);
      for (std::size_t corner = 0; corner < corners; ++corner) {
        const float s = corner == 1 || corner == 2, t = corner >= 2;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          first.push_back(at[axis] + s * a[axis] + t * b[axis]);
        }
        indices.push_back(static_cast<uint32_t>(indices.size()));
      }
    }
    Geometry geometry;
    geometry.shape = shape;
    geometry.vertex_count = first.size() / 3;
    geometry.primitive_count = count;
    for (std::size_t step = 0; step < steps; ++step) {
      std::vector<float> moved = first;
      if (step > 0) {
        for (float& x : moved) x += random_.Uniform(-0.1f, 0.1f);
      }
      geometry.vertices.push_back({Keep(std::move(moved)), 12});
    }
    indices_.push_back(std::make_unique<std::vector<uint32_t>>(std::move(indices)));
    geometry.primitives = {indices_.back()->data(), 4 * corners};
    return geometry;
  }

  Geometry Grid(uint16_t width, uint16_t height) {
    std::vector<float> vertices;
    for (uint16_t y = 0; y < height; ++y) {
      for (uint16_t x = 0; x < width; ++x) {
        const float u = static_cast<float>(x) / static_cast<float>(width - 1);
        const float v = static_cast<float>(y) / static_cast<float>(height - 1);
        vertices.insert(vertices.end(), {4 * u - 2, 4 * v - 2, random_.Uniform(-1.1f, -0.9f)});
      }
    }
    grids_.push_back(std::make_unique<GridPrimitive>(GridPrimitive{0, width, width, height}));
    Geometry geometry;
    geometry.shape = Shape::kGrids;
    geometry.vertex_count = vertices.size() / 3;
    geometry.primitive_count = 1;
    geometry.vertices = {{Keep(std::move(vertices)), 12}};
    geometry.primitives = {grids_.back().get(), sizeof(GridPrimitive)};
    return geometry;
  }

  Geometry Points(Shape shape, std::size_t count, std::size_t steps) {
    Geometry geometry;
    geometry.shape = shape;
    geometry.vertex_count = geometry.primitive_count = count;
    for (std::size_t step = 0; step < steps; ++step) {
      std::vector<float> points, normals;
      for (std::size_t i = 0; i < count; ++i) {
        const Float3 p = random_.InCube(-2, 2), n = random_.Direction();
        points.insert(points.end(), {p[0], p[1], p[2], random_.Uniform(0.01f, 0.1f)});
        normals.insert(normals.end(), n.begin(), n.end());
      }
      geometry.vertices.push_back({Keep(std::move(points)), 16});
      if (shape == Shape::kOrientedDiscs) {
        geometry.normals.push_back({Keep(std::move(normals)), 12});
      }
    }
    return geometry;
  }

  Geometry Users(std::size_t count) {
    std::vector<float> centers;
    for (std::size_t i = 0; i < count; ++i) {
      const Float3 p = random_.InCube(-2, 2);
      centers.insert(centers.end(), p.begin(), p.end());
    }
    Geometry geometry;
    geometry.shape = Shape::kUser;
    geometry.primitive_count = count;
    geometry.bounds = {UserSpheres::Bound, const_cast<void*>(Keep(std::move(centers)))};
    geometry.intersect = geometry.occluded = {UserSpheres::Intersect, geometry.bounds.data};
    return geometry;
  }

  const std::size_t scale_;
  Random random_;
  std::vector<std::unique_ptr<std::vector<float>>> floats_;
  std::vector<std::unique_ptr<std::vector<uint32_t>>> indices_;
  std::vector<std::unique_ptr<GridPrimitive>> grids_;
};

WorldScene::WorldScene(const Settings& settings, const Options& options)
    : world_(std::make_unique<World>(options.is_small ? 2 : 40, 1)),
      inner_world_(std::make_unique<World>(options.is_small ? 2 : 25, 2)) {
  const auto device = std::make_shared<Device>(settings);
  std::vector<Geometry> geometries = world_->Make(10, options.has_callbacks);
  const SceneOptions scene_options{options.keep, options.robust};
  if (options.has_instances) {
    const std::vector<Geometry> inner = inner_world_->Make(3, options.has_callbacks);
    const auto inner_scene = std::make_shared<Scene>(device, inner, scene_options);
    // Ids before and behind those of the others.
    geometries.push_back(World::Instance(1, inner_scene, 2, 0.3f, false));
    geometries.push_back(World::Instance(2, inner_scene, -2, 1.3f, true));
    geometries.push_back(World::Instance(50, inner_scene, 0, 2.3f, false));
  }
  scene = std::make_unique<Scene>(device, geometries, scene_options);
  EXPECT_EQ(scene->triangle_count() <= policy::kSmallScene, options.is_small);
}

WorldScene::~WorldScene() = default;

std::vector<FullRay> MakeFullRays(Random& random, std::size_t count) {
  std::vector<FullRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    Ray ray = MakeRay(random.InCube(-3, 3), random.Direction());
    if (random.Below(4) == 0) ray.tnear = random.Uniform(-0.5f, 1);
    if (random.Below(4) == 0) ray.tfar = random.Uniform(0.5f, 3);
    if (random.Below(20) == 0) ray.tfar = -1;
    ray.mask = random.Below(3) == 0 ? random.Below(8) : UINT32_MAX;
    rays.push_back(FullRayOf(ray, random.Uniform(0, 1)));
  }
  return rays;
}

}  // namespace dacrt::unit
