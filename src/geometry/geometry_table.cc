#include "geometry/geometry_table.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "dacrt/error.h"
#include "leaf/leaf_block.h"
#include "scene/scene_parts.h"

namespace dacrt {
namespace {

/// Whether the triangle test is all that a geometry needs.
bool IsPlain(const Geometry& geometry) {
  return geometry.shape == Shape::kTriangles && geometry.vertices.size() == 1 &&
         !geometry.closest_filter && !geometry.any_filter;
}

/// Quads are two triangles. What is handed to callbacks, or to another scene, should come alone.
std::size_t LanesFor(Shape shape) {
  switch (shape) {
    case Shape::kQuads:
    case Shape::kGrids:
      return 2;
    case Shape::kUser:
    case Shape::kInstance:
      return kLeafLanes;
    default:
      return 1;
  }
}

/// See GeometryTable::shares.
std::size_t SharesFor(Shape shape, uint32_t time_steps, std::size_t items) {
  // Leaves hold no more steps.
  const std::size_t halves = time_steps > kMostLeafSteps ? 2 : time_steps + 1;
  switch (shape) {
    case Shape::kTriangles:
      return items * halves / 2;
    case Shape::kQuads:
    case Shape::kGrids:
      return items * halves;
    case Shape::kUser:
      return items * 3;
    case Shape::kInstance:
      return items * 4;
    default:
      return items;
  }
}

Geometry ToGeometry(const TriangleMesh& mesh) {
  Geometry geometry;
  geometry.geometry_id = mesh.geometry_id;
  geometry.mask = mesh.mask;
  geometry.vertices = {{mesh.vertices, mesh.vertex_stride}};
  geometry.vertex_count = mesh.vertex_count;
  geometry.primitives = {mesh.triangles, mesh.triangle_stride};
  geometry.primitive_count = mesh.triangle_count;
  return geometry;
}

/// What the triangle test reads of a geometry; of other shapes than still triangles no vertices.
TriangleMesh ToMesh(const Geometry& geometry, std::size_t items) {
  TriangleMesh mesh;
  mesh.triangle_count = items;
  mesh.geometry_id = geometry.geometry_id;
  mesh.mask = geometry.mask;
  if (geometry.shape == Shape::kTriangles && geometry.vertices.size() == 1) {
    mesh.vertices = geometry.vertices[0].data;
    mesh.vertex_stride = geometry.vertices[0].stride;
    mesh.vertex_count = geometry.vertex_count;
    mesh.triangles = geometry.primitives.data;
    mesh.triangle_stride = geometry.primitives.stride;
  }
  return mesh;
}

std::vector<Geometry> ToGeometries(std::span<const TriangleMesh> meshes) {
  std::vector<Geometry> geometries;
  for (const TriangleMesh& mesh : meshes) geometries.push_back(ToGeometry(mesh));
  return geometries;
}

}  // namespace

GeometryTable::GeometryTable(std::span<const TriangleMesh> meshes)
    : GeometryTable(ToGeometries(meshes), std::vector<const SceneParts*>(meshes.size()), false) {}

GeometryTable::GeometryTable(std::span<const Geometry> geometries,
                             std::span<const SceneParts* const> scenes, bool robust)
    : is_plain_(!robust && std::all_of(geometries.begin(), geometries.end(), IsPlain)) {
  std::vector<std::size_t> order(geometries.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return geometries[a].geometry_id < geometries[b].geometry_id;
  });
  std::vector<Geometry> sorted;
  std::vector<const SceneParts*> sorted_scenes;
  sorted.reserve(order.size());
  sorted_scenes.reserve(order.size());
  for (const std::size_t i : order) {
    sorted.push_back(geometries[i]);
    sorted_scenes.push_back(scenes[i]);
  }
  shapes_.emplace(std::move(sorted), std::move(sorted_scenes), robust);
  for (uint32_t i = 0; i < shapes_->size(); ++i) {
    Add(ToMesh((*shapes_)[i], shapes_->ItemCount(i)));
    lanes_.push_back(static_cast<uint8_t>(LanesFor((*shapes_)[i].shape)));
    all_fill_one_lane_ &= lanes_.back() == 1;
    shares_ += SharesFor((*shapes_)[i].shape, shapes_->StepCount(i), shapes_->ItemCount(i));
    masks_.push_back(MaskOf(i));
  }
  FindCommonMask();
}

uint32_t GeometryTable::MaskOf(uint32_t geometry) const {
  const SceneParts* const scene = shapes_->InstancedScene(geometry);
  return meshes_[geometry].mask & (scene ? scene->geometries.common_mask_ : UINT32_MAX);
}

void GeometryTable::FindCommonMask() {
  common_mask_ = std::accumulate(masks_.begin(), masks_.end(), UINT32_MAX, std::bit_and());
}

std::optional<uint32_t> GeometryTable::Find(uint32_t geometry_id) const {
  if (meshes_.empty()) return std::nullopt;
  const auto is_at = [&](std::size_t place) {
    return place < meshes_.size() && meshes_[place].geometry_id == geometry_id;
  };
  // IDs mostly are numbers in a row.
  std::size_t place = geometry_id - meshes_.front().geometry_id;
  if (!is_at(place) || (place > 0 && is_at(place - 1))) {
    place = static_cast<std::size_t>(
        std::ranges::lower_bound(meshes_, geometry_id, {}, &TriangleMesh::geometry_id) -
        meshes_.begin());
  }
  if (!is_at(place) || is_at(place + 1)) return std::nullopt;
  return static_cast<uint32_t>(place);
}

bool GeometryTable::have_own_ids() const {
  return std::ranges::adjacent_find(meshes_, {}, &TriangleMesh::geometry_id) == meshes_.end();
}

void GeometryTable::Exchange(uint32_t geometry, Shapes::Successor& successor) noexcept {
  shapes_->Exchange(geometry, successor);
  meshes_[geometry] = ToMesh((*shapes_)[geometry], shapes_->ItemCount(geometry));
  const uint32_t mask = std::exchange(masks_[geometry], MaskOf(geometry));
  if (masks_[geometry] != mask) FindCommonMask();
}

void GeometryTable::Add(const TriangleMesh& mesh) {
  // Compared before they are added: counts that the caller got wrong may overflow the sum.
  constexpr std::size_t kMostTriangles = std::numeric_limits<int32_t>::max() - 1;
  if (mesh.triangle_count > kMostTriangles - triangle_count_) {
    throw Error(Error::Kind::kTooLarge, "Scene",
                "geometry " + std::to_string(mesh.geometry_id) + ": primitive count",
                std::to_string(mesh.triangle_count),
                "the scene would have more than 2^31 - 2 primitives");
  }
  first_.push_back(static_cast<uint32_t>(triangle_count_));
  triangle_count_ += mesh.triangle_count;
  have_one_each_ &= mesh.triangle_count == 1;
  meshes_.push_back(mesh);
}

}  // namespace dacrt
