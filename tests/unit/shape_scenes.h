// What tests of scenes of all shapes share: models of triangles and points, and rays with a time.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dacrt/dacrt.h"
#include "unit_test.h"

namespace dacrt::unit {

/// A ray that moves in time.
struct TimedRay : Ray {
  float time = 0;
};

inline RayView TimedView(std::span<TimedRay> rays) {
  RayView view = ViewOf({static_cast<Ray*>(rays.data()), 1});
  view.count = rays.size();
  view.packet_stride = sizeof(TimedRay);
  view.time = reinterpret_cast<RayView::Component>(&rays[0].time);
  return view;
}

/// Vertices and indices of any shape, with the geometry that describes them.
struct Model {
  std::vector<std::vector<float>> steps;  ///< floats of each time step's vertices
  std::vector<float> normals;
  std::vector<uint32_t> indices;
  std::vector<GridPrimitive> grids;
  Geometry geometry;

  Geometry View(std::size_t floats_a_vertex) const {
    Geometry view = geometry;
    view.vertex_count = steps[0].size() / floats_a_vertex;
    for (const auto& step : steps) {
      view.vertices.push_back({step.data(), floats_a_vertex * sizeof(float)});
    }
    return view;
  }
};

inline Model MakeTriangles(Random& random, std::size_t count) {
  Model model;
  model.steps.resize(1);
  for (std::size_t i = 0; i < count; ++i) {
    const Float3 at = random.InCube(-2, 2);
    for (int corner = 0; corner < 3; ++corner) {
      const Float3 off = random.InCube(-0.4f, 0.4f);
      for (std::size_t axis = 0; axis < 3; ++axis) model.steps[0].push_back(at[axis] + off[axis]);
      model.indices.push_back(static_cast<uint32_t>(model.indices.size()));
    }
  }
  return model;
}

inline Geometry TriangleView(const Model& model, uint32_t id) {
  Geometry view = model.View(3);
  view.shape = Shape::kTriangles;
  view.geometry_id = id;
  view.primitive_count = model.indices.size() / 3;
  view.primitives = {model.indices.data(), 12};
  return view;
}

inline Model MakePoints(Random& random, std::size_t count) {
  Model model;
  model.steps.resize(1);
  for (std::size_t i = 0; i < count; ++i) {
    for (const float value : random.InCube(-2, 2)) model.steps[0].push_back(value);
    model.steps[0].push_back(random.Uniform(0.01f, 0.3f));
    for (const float value : random.Direction()) model.normals.push_back(value);
  }
  return model;
}

inline Geometry PointView(const Model& model, Shape shape, uint32_t id) {
  Geometry view = model.View(4);
  view.shape = shape;
  view.geometry_id = id;
  view.primitive_count = view.vertex_count;
  if (shape == Shape::kOrientedDiscs) view.normals = {{model.normals.data(), 12}};
  return view;
}

inline std::vector<TimedRay> MakeRays(Random& random, std::size_t count) {
  std::vector<TimedRay> rays(count);
  for (TimedRay& ray : rays) {
    ray.org = random.InCube(-3, 3);
    ray.dir = random.Direction();
    ray.time = random.Uniform(0, 1);
  }
  return rays;
}

inline std::vector<TimedRay> Trace(const Scene& scene, std::vector<TimedRay> rays,
                                   Query query = Query::kClosest, const CallOptions& options = {}) {
  scene.Trace(query, TimedView(rays), options);
  return rays;
}

inline std::shared_ptr<Scene> MakeScene(const std::vector<Geometry>& geometries, uint64_t budget,
                                        bool robust = false, uint32_t threads = 2) {
  Settings settings;
  settings.budget = budget;
  settings.threads = threads;
  return std::make_shared<Scene>(std::make_shared<Device>(settings), geometries,
                                 SceneOptions{Keep::kByBudget, robust});
}

inline void ExpectSameRays(const std::vector<TimedRay>& actual,
                           const std::vector<TimedRay>& expected, const std::string& what) {
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_TRUE(SameBits(actual[i], expected[i]))
        << what << ": ray " << i << ": t " << std::hexfloat << actual[i].tfar << " geometry "
        << actual[i].geometry_id << " primitive " << actual[i].primitive_id << ", expected "
        << expected[i].tfar << " geometry " << expected[i].geometry_id << " primitive "
        << expected[i].primitive_id;
  }
}

inline std::size_t CountHits(const std::vector<TimedRay>& rays) {
  return static_cast<std::size_t>(
      std::count_if(rays.begin(), rays.end(), [](const Ray& ray) { return ray.IsHit(); }));
}

/// A filter function that accepts everything makes triangles go the way of all shapes.
inline void AcceptAll(void*, const CallbackArguments&) {}

/// A user geometry without functions. Where there is one, filter functions are asked at once.
inline Geometry UserGeometry(uint32_t id) {
  Geometry user;
  user.shape = Shape::kUser;
  user.geometry_id = id;
  user.primitive_count = 1;
  user.bounds = {[](void*, uint32_t, uint32_t, Bounds& bounds) {
                   bounds = {{0, 0, 0}, {0.1f, 0.1f, 0.1f}};
                 },
                 nullptr};
  return user;
}

/// Counts how often it is asked, and accepts.
inline void CountAsked(void* data, const CallbackArguments& arguments) {
  auto& asked = *static_cast<std::size_t*>(data);
  for (uint32_t lane = 0; lane < arguments.width; ++lane) asked += arguments.valid[lane] == -1;
}

}  // namespace dacrt::unit
