// A commit: geometries become a scene. Where nothing is kept it only counts what can be hit.

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dacrt/dacrt.h"
#include "engine/call_plan.h"
#include "engine/device.h"
#include "geometry/geometry_table.h"
#include "geometry/triangle_refs.h"
#include "partition/kept_partition.h"
#include "scene/scene_implementation.h"
#include "trace/policy.h"

namespace dacrt {
namespace {

[[noreturn]] void RefuseDevice() {
  throw Error(Error::Kind::kArgument, "Scene", "device", "null", "a scene belongs to a device");
}

}  // namespace

Scene::Scene(std::shared_ptr<Device> device, std::span<const TriangleMesh> meshes, Keep keep) {
  if (!device) RefuseDevice();
  implementation_ = std::make_unique<Implementation>(std::move(device), GeometryTable(meshes),
                                                     SceneOptions{.keep = keep});
}

Scene::Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
             const SceneOptions& options) {
  GeometryTable table = Implementation::MakeTable(device.get(), geometries, options.robust);
  implementation_ = std::make_unique<Implementation>(std::move(device), std::move(table), options);
}

Scene::Scene(std::shared_ptr<Device> device, std::span<const Geometry> geometries,
             const SceneOptions& options, const Scene& previous) {
  GeometryTable table = Implementation::MakeTable(device.get(), geometries, options.robust);
  implementation_ = std::make_unique<Implementation>(std::move(device), std::move(table), options,
                                                     previous.implementation_.get());
}

Scene::Implementation::Implementation(std::shared_ptr<Device> shared_device,
                                      GeometryTable geometries, const SceneOptions& options,
                                      const Implementation* previous)
    : device(std::move(shared_device)),
      parts{std::move(geometries)},
      prepared_(Engine().prepared_scenes, parts.geometries.shares()) {
  if (previous && PlanRefit(*previous, options)) {
    parts.triangle_count =
        previous->parts.triangle_count + (growth_ ? growth_->triangle_count() : 0);
  } else if (Engine().Keeps()) {
    const Keep keep = options.keep;
    // Whoever wants to keep little wants no spare memory either.
    SparePages* const spare = keep == Keep::kLittle ? nullptr : &Engine().spare_pages;
    parts.kept = std::make_unique<KeptPartition>(
        parts.geometries, Engine().BudgetBytes(parts.geometries, keep, prepared_.has_room()),
        Engine().kernels.partition.first_look, Engine().tasks, &Engine().memory, spare);
    if (options.splits_with_care) parts.kept->SplitWithCare();
    parts.bounds = parts.kept->bounds();
    parts.triangle_count = parts.kept->triangle_count();
  } else {
    CountTriangles();
  }
  // What is taken over keeps the room that it was made with.
  parts.prepares_leaves = prepared_.has_room() && (!refit_plan_ || previous->parts.prepares_leaves);
  const Shapes& shapes = parts.geometries.shapes();
  parts.has_callbacks = shapes.has_callbacks();
  parts.is_small = parts.triangle_count <= policy::kSmallScene;
  for (uint32_t i = 0; i < shapes.size(); ++i) {
    parts.has_motion |= shapes.IsMoving(i);
    const SceneParts* const scene = shapes.InstancedScene(i);
    if (!scene) continue;
    parts.has_instances = true;
    parts.has_callbacks |= scene->has_callbacks;
    parts.is_small &= scene->is_small;
  }
  parts.closest_filters_may_wait = parts.kept && shapes.has_filters(Query::kClosest) &&
                                   !shapes.has_user_primitives() && !parts.has_instances &&
                                   parts.geometries.have_own_ids();
  // A scene that keeps nothing needs as much as its call for each triangle: that is not reserved.
  if (Engine().Keeps())
    Engine().workspaces.KeepFloor(Shape(CallPlan::Least(true, Engine().settings)));
}

GeometryTable Scene::Implementation::MakeTable(const Device* device,
                                               std::span<const Geometry> geometries, bool robust) {
  if (!device) RefuseDevice();
  std::vector<const SceneParts*> scenes;
  for (const Geometry& geometry : geometries) scenes.push_back(PartsFor(geometry, device));
  return GeometryTable(geometries, scenes, robust);
}

const SceneParts* Scene::Implementation::PartsFor(const Geometry& geometry, const Device* device) {
  if (geometry.shape != dacrt::Shape::kInstance) return nullptr;
  const auto refuse = [&](const char* value, const char* reason) {
    throw Error(Error::Kind::kArgument, "Scene",
                "geometry " + std::to_string(geometry.geometry_id) + ": instanced_scene", value,
                reason);
  };
  if (!geometry.instanced_scene) refuse("null", "an instance shows a scene");
  const Implementation& inner = *geometry.instanced_scene->implementation_;
  if (inner.device.get() != device) refuse("a scene of another device", "it must be of this one");
  return &inner.parts;
}

void Scene::Implementation::CountTriangles() {
  const GeometryTable& geometries = parts.geometries;
  Box& bounds = parts.bounds;
  for (uint32_t geometry = 0; geometry < geometries.size(); ++geometry) {
    for (uint32_t primitive = 0; primitive < geometries[geometry].triangle_count; ++primitive) {
      TriangleRef ref;
      if (!BoundTriangle(geometries, geometry, primitive, ref)) continue;
      bounds.Extend(ref.lower);
      bounds.Extend(ref.upper);
      ++parts.triangle_count;
    }
  }
}

}  // namespace dacrt
