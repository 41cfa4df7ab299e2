// A committed scene: what it says of itself, and its nearest points. How it is made, changed and
// traced stands in commit.cc, take_over.cc, update.cc and trace_call.cc.

#include "dacrt/dacrt.h"
#include "engine/device.h"
#include "geometry/geometry_table.h"
#include "partition/kept_partition.h"
#include "scene/scene_implementation.h"

namespace dacrt {

Scene::~Scene() = default;

Bounds Scene::bounds() const { return ToBounds(implementation_->parts.bounds); }

LinearBounds Scene::linear_bounds() const {
  return implementation_->parts.geometries.shapes().BoundLinearly();
}

std::size_t Scene::triangle_count() const { return implementation_->parts.triangle_count; }

std::size_t Scene::KeptBytes() const {
  const auto& kept = implementation_->parts.kept;
  return kept ? kept->BytesReserved() : 0;
}

std::size_t Scene::KeptBytesUsed() const {
  const auto& kept = implementation_->parts.kept;
  return kept ? kept->BytesUsed() : 0;
}

std::size_t Scene::WorkspaceBytes(std::size_t ray_count) const {
  return implementation_->CallBytes(ray_count);
}

void Scene::QueryPoint(const PointQuery& query) const {
  if (!(query.radius >= 0)) return;
  Device::Implementation& engine = implementation_->Engine();
  PointTask task{query, query.radius, engine.workspaces};
  engine.kernels.query_point(task, implementation_->parts);
}

}  // namespace dacrt
