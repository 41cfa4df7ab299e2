// Scenes that come in the place of others, frame by frame, beside scenes that are made anew.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "unit_test.h"

namespace dacrt::unit {

/// Some hilly sheets in [-1, 1]^3, one above the other.
inline std::vector<Mesh> MakeSheets(uint32_t count, uint32_t side) {
  std::vector<Mesh> sheets(count);
  for (uint32_t i = 0; i < count; ++i) {
    Mesh& mesh = sheets[i];
    mesh.geometry_id = 3 * i;
    for (uint32_t y = 0; y <= side; ++y) {
      for (uint32_t x = 0; x <= side; ++x) {
        const float u = 2.0f * x / side - 1, v = 2.0f * y / side - 1;
        const float height = 0.1f * std::sin(9 * u) * std::cos(7 * v);
        mesh.vertices.push_back({u, v, height + 2.0f * (i + 1) / (count + 1) - 1});
      }
    }
    const uint32_t row = side + 1;
    for (uint32_t y = 0; y < side; ++y) {
      for (uint32_t x = 0; x < side; ++x) {
        const uint32_t v = y * row + x;
        mesh.triangles.push_back({v, v + 1, v + row});
        mesh.triangles.push_back({v + row + 1, v + row, v + 1});
      }
    }
  }
  return sheets;
}

/// A scene from frame to frame.
class Film {
 public:
  explicit Film(std::vector<Mesh> sheets, std::size_t threads = 1)
      : meshes(std::move(sheets)), revisions(meshes.size(), 1), hidden(meshes.size()) {
    Settings settings;
    settings.threads = threads;
    device_ = std::make_shared<Device>(settings);
    scene_ = std::make_unique<Scene>(device_, Geometries(), SceneOptions{});
  }

  /// The next frame. Returns whether it took over the partition of the one before.
  bool Advance(const SceneOptions& options = {}) {
    auto next = std::make_unique<Scene>(device_, Geometries(), options, *scene_);
    const bool takes_over = next->takes_over();
    next->TakeOver(*scene_);
    EXPECT_FALSE(next->takes_over());
    scene_ = std::move(next);
    return takes_over;
  }

  /// The next frame, in which one mesh has moved or has another mask, without another scene. False
  /// if that would not do.
  bool Update(std::size_t mesh) { return scene_->Update({Describe(mesh)}); }
  bool Hide(std::size_t mesh) {
    hidden[mesh] = true;
    Geometry description;
    description.geometry_id = meshes[mesh].geometry_id;
    description.hidden = true;
    return scene_->Update({description});
  }

  /// Goes on with a copy of the partition; returns the scene that has had it until now.
  std::unique_ptr<Scene> Copy() {
    auto next = std::make_unique<Scene>(device_, Geometries(), SceneOptions{}, *scene_);
    EXPECT_TRUE(next->takes_over());
    next->TakeCopy(*scene_);
    EXPECT_FALSE(next->takes_over());
    scene_.swap(next);
    return next;
  }

  /// Compares the hits of rays with those of a scene that is made anew.
  void Check(std::size_t count) const {
    Random random(count);
    std::vector<Ray> rays = MakeRays(random, count, 1.2f);
    std::vector<Ray> expected = rays;
    const Scene fresh(device_, Geometries(), SceneOptions{});
    fresh.Trace(Query::kClosest, ViewOf(expected));
    scene_->Trace(Query::kClosest, ViewOf(rays));
    std::size_t hits = 0;
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_TRUE(SameBits(rays[i], expected[i])) << "ray " << i;
      hits += rays[i].IsHit();
    }
    if (count >= 50) {
      EXPECT_GT(hits, 0u);
    }
    const Bounds own = scene_->bounds(), bounds = fresh.bounds();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(own.lower[axis], bounds.lower[axis]);
      EXPECT_EQ(own.upper[axis], bounds.upper[axis]);
    }
    if (std::ranges::none_of(hidden, std::identity())) {
      EXPECT_EQ(scene_->triangle_count(), fresh.triangle_count());
    }
  }

  void ForEachVertex(const std::function<void(Float3&)>& move) {
    for (Mesh& mesh : meshes) std::for_each(mesh.vertices.begin(), mesh.vertices.end(), move);
    for (uint64_t& revision : revisions) ++revision;
  }

  Scene& scene() { return *scene_; }

  std::vector<Mesh> meshes;
  std::vector<uint64_t> revisions;
  std::vector<bool> hidden;  ///< which meshes are

 private:
  Geometry Describe(std::size_t mesh) const {
    Geometry geometry = GeometryOf(meshes[mesh]);
    geometry.revision = revisions[mesh];
    return geometry;
  }

  std::vector<Geometry> Geometries() const {
    std::vector<Geometry> geometries;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      if (!hidden[i]) geometries.push_back(Describe(i));
    }
    return geometries;
  }

  std::shared_ptr<Device> device_;
  std::unique_ptr<Scene> scene_;
};

inline void Wave(Film& film, float phase) {
  film.ForEachVertex([=](Float3& v) { v[2] += 0.01f * std::sin(phase + 4 * v[0]); });
}

}  // namespace dacrt::unit
