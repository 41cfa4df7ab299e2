#include "geometry/shapes.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "dacrt/error.h"
#include "geometry/instance_bounds.h"
#include "scene/scene_parts.h"

namespace dacrt {
namespace {

constexpr std::size_t kMostSteps = 129;
constexpr uint32_t kLeastGrid = 2, kMostGrid = 32767;

template <class T>
T Read(const Array& array, std::size_t i, std::size_t offset = 0) {
  T value;
  std::memcpy(&value, static_cast<const char*>(array.data) + i * array.stride + offset * sizeof(T),
              sizeof(T));
  return value;
}

bool HasFacets(Shape shape) {
  return shape == Shape::kTriangles || shape == Shape::kQuads || shape == Shape::kGrids;
}

bool HasPoints(Shape shape) {
  return shape == Shape::kSpheres || shape == Shape::kDiscs || shape == Shape::kOrientedDiscs;
}

[[noreturn]] void Refuse(const Geometry& geometry, const char* member, const std::string& value,
                         const std::string& reason, Error::Kind kind = Error::Kind::kArgument) {
  throw Error(kind, "Scene", "geometry " + std::to_string(geometry.geometry_id) + ": " + member,
              value, reason);
}

void CheckArray(const Array& array, std::size_t count, const char* name, const Geometry& geometry) {
  if (count == 0) return;
  if (array.data == nullptr) {
    Refuse(geometry, name, "null", "its count is " + std::to_string(count));
  }
  const auto address = reinterpret_cast<std::uintptr_t>(array.data);
  if (address % 4 != 0) {
    Refuse(geometry, name, std::to_string(address), "the address is not aligned to 4 bytes");
  }
  if (array.stride % 4 != 0) {
    Refuse(geometry, name, "stride " + std::to_string(array.stride), "no multiple of 4");
  }
}

const char* PrimitivesName(Shape shape) {
  return shape == Shape::kTriangles ? "triangles" : shape == Shape::kQuads ? "quads" : "grids";
}

void CheckSteps(std::size_t steps, const char* name, const Geometry& geometry) {
  if (steps >= 1 && steps <= kMostSteps) return;
  Refuse(geometry, name, std::to_string(steps) + " time steps", "it takes 1 to 129");
}

void CheckArrays(const Geometry& geometry) {
  CheckSteps(geometry.vertices.size(), "vertices", geometry);
  if (geometry.primitive_count == 0) return;
  for (const Array& array : geometry.vertices)
    CheckArray(array, geometry.vertex_count, "vertices", geometry);
  if (HasFacets(geometry.shape)) {
    CheckArray(geometry.primitives, geometry.primitive_count, PrimitivesName(geometry.shape),
               geometry);
  }
  if (geometry.shape != Shape::kOrientedDiscs) return;
  if (geometry.normals.size() != geometry.vertices.size()) {
    Refuse(geometry, "normals", std::to_string(geometry.normals.size()) + " time steps",
           "vertices have " + std::to_string(geometry.vertices.size()));
  }
  for (const Array& array : geometry.normals)
    CheckArray(array, geometry.vertex_count, "normals", geometry);
}

/// As Embree does it, so that moving vertices have its bits.
float Interpolate(float a, float b, float fraction) {
  return std::fma(1.0f - fraction, a, fraction * b);
}

/// Whether all vertices of a grid are there. As with Embree, one that reaches beyond them is left
/// out as a whole, which also costs no look at its cells.
bool IsLegal(const GridPrimitive& grid, std::size_t vertex_count) {
  const auto is_legal = [](uint32_t count) { return count >= kLeastGrid && count <= kMostGrid; };
  if (!is_legal(grid.width) || !is_legal(grid.height)) return false;
  const std::size_t last =
      grid.first_vertex + std::size_t{grid.vertex_stride} * (grid.height - 1u) + grid.width - 1u;
  return last < vertex_count;
}

bool AreUsable(const Bounds& bounds) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(bounds.lower[axis] <= bounds.upper[axis])) return false;
  }
  return IsUsable(bounds.lower) && IsUsable(bounds.upper);
}

/// What hidden instances show: one point, where there is nothing. It is nobody's, since what they
/// have shown may be released.
const SceneParts& NoScene() {
  // Never destroyed: threads may trace while a program ends.
  static const auto* const none =
      new SceneParts{GeometryTable(std::span<const TriangleMesh>()), Box{}};
  return *none;
}

}  // namespace

Shapes::Shapes(std::vector<Geometry> geometries, std::vector<const SceneParts*> scenes, bool robust)
    : geometries_(std::move(geometries)), robust_(robust) {
  derived_.reserve(geometries_.size());
  for (uint32_t i = 0; i < geometries_.size(); ++i) {
    derived_.emplace_back(geometries_[i], scenes[i]);
    geometries_[i].bounds = {};
    has_closest_filters_ |= static_cast<bool>(geometries_[i].closest_filter);
    has_any_filters_ |= static_cast<bool>(geometries_[i].any_filter);
    has_user_primitives_ |= geometries_[i].shape == Shape::kUser;
  }
}

Shapes::Derived::Derived(const Geometry& geometry, const SceneParts* instanced_scene)
    : item_count(geometry.hidden ? 0 : geometry.primitive_count),
      is_hidden(geometry.hidden),
      primitives(geometry.primitives),
      scene(instanced_scene) {
  if (geometry.hidden) return;
  switch (geometry.shape) {
    case Shape::kInstance:
      PlaceInstance(geometry);
      break;
    case Shape::kUser:
      CallBoundsFunction(geometry);
      break;
    default:
      CheckArrays(geometry);
      steps = static_cast<uint32_t>(geometry.vertices.size());
      if (geometry.shape == Shape::kGrids) CountCells(geometry);
  }
}

void Shapes::Derived::CallBoundsFunction(const Geometry& g) {
  CheckSteps(g.user_time_steps, "user_time_steps", g);
  steps = g.user_time_steps;
  if (!g.bounds.function) item_count = 0;
  bounds.reserve(item_count * steps);
  for (uint32_t item = 0; item < item_count; ++item) {
    for (uint32_t step = 0; step < steps; ++step) {
      Bounds at_step{{1, 1, 1}, {-1, -1, -1}};
      g.bounds.function(g.bounds.data, item, step, at_step);
      Box box = Box::Empty();
      if (AreUsable(at_step)) {
        box.Extend(at_step.lower);
        box.Extend(at_step.upper);
      }
      bounds.push_back(box);
    }
  }
}

void Shapes::Derived::CountCells(const Geometry& g) {
  std::size_t cells = 0;
  for (uint32_t grid = 0; grid < g.primitive_count; ++grid) {
    if (cells >= UINT32_MAX) {
      Refuse(g, "primitives", std::to_string(cells) + " grid cells", "too many to be numbered",
             Error::Kind::kTooLarge);
    }
    first_cells.push_back(static_cast<uint32_t>(cells));
    const auto primitive = Read<GridPrimitive>(g.primitives, grid);
    if (!IsLegal(primitive, g.vertex_count)) continue;
    // All rows of a grid without a stride are one, so that no cell has an area and the first row of
    // them bounds the grid: a few vertices could ask for a billion.
    const std::size_t rows = primitive.vertex_stride == 0 ? 1 : primitive.height - 1u;
    cells += (primitive.width - 1u) * rows;
  }
  item_count = cells;
}

void Shapes::Derived::PlaceInstance(const Geometry& g) {
  CheckSteps(g.transforms.size(), "transforms", g);
  item_count = 1;
  steps = static_cast<uint32_t>(g.transforms.size());
  bounds.resize(steps);
  BoundInstance(g.transforms, scene->bounds, bounds.data());
  to_instance = ToFirstStep(g.transforms);
}

Shapes::Successor Shapes::Hidden(uint32_t geometry) const {
  // What any index of a triangle or a quad is, what any grid is made of, and any point.
  static constexpr uint32_t kNowhere[4] = {UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};
  static_assert(sizeof(GridPrimitive) <= sizeof(kNowhere));
  Geometry hidden = geometries_[geometry];
  if (hidden.hidden) return Successor(std::move(hidden), derived_[geometry]);
  hidden.revision = 0;
  if (hidden.shape == Shape::kInstance) {
    hidden.instanced_scene = nullptr;
    Successor successor(std::move(hidden), &NoScene());
    successor.geometry_.hidden = successor.derived_.is_hidden = true;
    return successor;
  }
  hidden.hidden = true;
  hidden.intersect = hidden.occluded = {};
  hidden.primitives = {kNowhere, 0};
  hidden.vertices.assign(hidden.vertices.size(), {kNowhere, 0});
  hidden.normals.assign(hidden.normals.size(), {kNowhere, 0});
  hidden.vertex_count = 0;
  Successor successor(std::move(hidden), derived_[geometry]);
  successor.derived_.is_hidden = true;
  return successor;
}

bool Shapes::AddPlace(uint32_t geometry, std::span<const TransformStep> transforms,
                      Places& places) const {
  const Derived& derived = derived_[geometry];
  if (!derived.scene || derived.is_hidden || derived.steps != transforms.size()) return false;
  hwy::Prefetch(geometries_[geometry].transforms.data());  // to be exchanged
  places.places_.push_back({geometry, ToFirstStep(transforms)});
  places.transforms_.insert(places.transforms_.end(), transforms.begin(), transforms.end());
  places.bounds_.resize(places.bounds_.size() + transforms.size());
  BoundInstance(transforms, derived.scene->bounds,
                places.bounds_.data() + places.bounds_.size() - transforms.size());
  return true;
}

void Shapes::Exchange(Places& places) noexcept {
  auto transforms = places.transforms_.begin();
  auto bounds = places.bounds_.begin();
  for (Places::Place& place : places.places_) {
    Geometry& geometry = geometries_[place.geometry];
    Derived& derived = derived_[place.geometry];
    transforms =
        std::swap_ranges(geometry.transforms.begin(), geometry.transforms.end(), transforms);
    bounds = std::swap_ranges(derived.bounds.begin(), derived.bounds.end(), bounds);
    std::swap(derived.to_instance, place.to_instance);
  }
}

bool Shapes::CanExchange(uint32_t geometry, const Successor& successor) const {
  const Geometry &a = geometries_[geometry], &b = successor.geometry_;
  const auto are_alike = [](const Callback& x, const Callback& y) {
    return static_cast<bool>(x) == static_cast<bool>(y);
  };
  return a.shape == b.shape && a.geometry_id == b.geometry_id &&
         derived_[geometry].item_count == successor.derived_.item_count &&
         derived_[geometry].steps == successor.derived_.steps &&
         derived_[geometry].primitives.data == successor.derived_.primitives.data &&
         derived_[geometry].primitives.stride == successor.derived_.primitives.stride &&
         are_alike(a.closest_filter, b.closest_filter) && are_alike(a.any_filter, b.any_filter);
}

bool Shapes::StandAsBefore(uint32_t geometry, const Successor& successor) const {
  const auto are_same = [](const Box& a, const Box& b) {
    return std::equal(a.lower, a.lower + 3, b.lower) && std::equal(a.upper, a.upper + 3, b.upper);
  };
  return geometries_[geometry].shape == Shape::kUser && !IsHidden(geometry) &&
         !successor.derived_.is_hidden &&
         std::ranges::equal(derived_[geometry].bounds, successor.derived_.bounds, are_same);
}

bool Shapes::BoundItem(uint32_t geometry, uint32_t item, uint32_t begin, uint32_t end,
                       Box& bounds) const {
  const Geometry& g = geometries_[geometry];
  const Derived& derived = derived_[geometry];
  bounds = Box::Empty();
  if (derived.scene || g.shape == Shape::kUser) {
    for (uint32_t step = begin; step < end; ++step) {
      const Box& box = derived.bounds[std::size_t{item} * derived.steps + step];
      if (box.IsEmpty()) return false;
      bounds.Extend(box);
    }
    return true;
  }
  uint32_t index[4] = {item};
  std::size_t corners = 1;
  if (HasFacets(g.shape) && !FacetIndices(geometry, item, index, corners)) return false;
  if (!HasFacets(g.shape) && item >= g.vertex_count) return false;
  for (uint32_t step = begin; step < end; ++step) {
    for (std::size_t i = 0; i < corners; ++i) {
      float corner[4] = {};
      std::memcpy(
          corner,
          static_cast<const char*>(g.vertices[step].data) + index[i] * g.vertices[step].stride,
          HasPoints(g.shape) ? 16 : 12);
      if (!IsUsable(corner)) return false;
      const float radius = corner[3];
      if (!(radius >= 0 && radius <= kLargestCoordinate)) return false;
      for (int axis = 0; axis < 3; ++axis) {
        bounds.lower[axis] = std::min(bounds.lower[axis], corner[axis] - radius);
        bounds.upper[axis] = std::max(bounds.upper[axis], corner[axis] + radius);
      }
    }
    if (g.shape == Shape::kOrientedDiscs) {
      float normal[3];
      std::memcpy(normal,
                  static_cast<const char*>(g.normals[step].data) + item * g.normals[step].stride,
                  sizeof(normal));
      if (!IsUsable(normal)) return false;
    }
  }
  return true;
}

Box Shapes::BoundItemAt(uint32_t geometry, uint32_t item, Moment moment) const {
  Box bounds, end;
  BoundItem(geometry, item, moment.step, moment.step + 1, bounds);
  if (!IsMoving(geometry)) return bounds;
  BoundItem(geometry, item, moment.step + 1, moment.step + 2, end);
  // Rounded as what moves in them is, so that it stays in them.
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = Interpolate(bounds.lower[axis], end.lower[axis], moment.fraction);
    bounds.upper[axis] = Interpolate(bounds.upper[axis], end.upper[axis], moment.fraction);
  }
  return bounds;
}

GridCell Shapes::CellOf(uint32_t geometry, uint32_t item) const {
  const std::vector<uint32_t>& first = derived_[geometry].first_cells;
  const auto grid =
      static_cast<uint32_t>(std::upper_bound(first.begin(), first.end(), item) - first.begin() - 1);
  const auto primitive = Read<GridPrimitive>(geometries_[geometry].primitives, grid);
  // The program may have written another width meanwhile, even none.
  const uint32_t columns = std::max<uint32_t>(primitive.width, kLeastGrid) - 1;
  const uint32_t cell = item - first[grid];
  return {grid, cell % columns, cell / columns, columns, primitive.height - 1u};
}

bool Shapes::FacetIndices(uint32_t geometry, uint32_t item, uint32_t* index,
                          std::size_t& corners) const {
  const Geometry& g = geometries_[geometry];
  if (g.shape == Shape::kGrids) {
    const GridCell cell = CellOf(geometry, item);
    const auto grid = Read<GridPrimitive>(g.primitives, cell.primitive);
    const std::size_t stride = grid.vertex_stride;
    const std::size_t last = grid.first_vertex + stride * (cell.y + 1) + cell.x + 1;
    if (last >= g.vertex_count) return false;
    const auto first = static_cast<uint32_t>(grid.first_vertex + stride * cell.y + cell.x);
    corners = 4;
    index[0] = first;
    index[1] = first + 1;
    index[2] = static_cast<uint32_t>(last);
    index[3] = static_cast<uint32_t>(last) - 1;
    return true;
  }
  corners = g.shape == Shape::kQuads ? 4 : 3;
  for (std::size_t i = 0; i < corners; ++i) {
    index[i] = Read<uint32_t>(g.primitives, item, i);
    if (index[i] >= g.vertex_count) return false;
  }
  return true;
}

bool Shapes::ReadFacet(uint32_t geometry, uint32_t item, uint32_t step, Facet& facet) const {
  const Array& vertices = geometries_[geometry].vertices[step];
  uint32_t index[4];
  std::size_t corners;
  if (!FacetIndices(geometry, item, index, corners)) return false;
  for (std::size_t i = 0; i < corners; ++i) {
    std::memcpy(facet.corner[i],
                static_cast<const char*>(vertices.data) + index[i] * vertices.stride,
                sizeof(facet.corner[i]));
  }
  return true;
}

bool Shapes::ReadFacet(uint32_t geometry, uint32_t item, Moment moment, Facet& facet) const {
  if (!ReadFacet(geometry, item, moment.step, facet)) return false;
  if (!IsMoving(geometry)) return true;
  Facet end;
  ReadFacet(geometry, item, moment.step + 1, end);
  for (int corner = 0; corner < 4; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      facet.corner[corner][axis] =
          Interpolate(facet.corner[corner][axis], end.corner[corner][axis], moment.fraction);
    }
  }
  return true;
}

void Shapes::ReadPoint(uint32_t geometry, uint32_t item, Moment moment, Point& point) const {
  const Geometry& g = geometries_[geometry];
  const auto read = [&](const std::vector<Array>& arrays, std::size_t component) {
    const float value = Read<float>(arrays[moment.step], item, component);
    if (derived_[geometry].steps == 1) return value;
    return Interpolate(value, Read<float>(arrays[moment.step + 1], item, component),
                       moment.fraction);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    point.center[axis] = read(g.vertices, axis);
    point.normal[axis] = g.shape == Shape::kOrientedDiscs ? read(g.normals, axis) : 0;
  }
  point.radius = read(g.vertices, 3);
}

AffineTransform Shapes::ToInstance(uint32_t geometry, float time) const {
  if (!IsMoving(geometry)) return derived_[geometry].to_instance;
  const Geometry& g = geometries_[geometry];
  return Inverse(TransformAt(g.transforms, g.time_range, time));
}

LinearBounds Shapes::BoundLinearly() const {
  Box first = Box::Empty(), last = Box::Empty();
  for (uint32_t geometry = 0; geometry < size(); ++geometry) {
    const uint32_t steps = derived_[geometry].steps;
    std::vector<Box> boxes(steps, Box::Empty());
    for (uint32_t item = 0; item < ItemCount(geometry); ++item) {
      Box box;
      if (!BoundItem(geometry, item, box)) continue;
      for (uint32_t step = 0; step < steps; ++step) {
        if (BoundItem(geometry, item, step, step + 1, box)) boxes[step].Extend(box);
      }
    }
    if (boxes[0].IsEmpty()) continue;
    Box begin = boxes.front(), end = boxes.back();
    if (steps > 1 && (geometries_[geometry].time_range.begin != 0 ||
                      geometries_[geometry].time_range.end != 1)) {
      // Some other time: what holds at all of them.
      for (const Box& box : boxes) begin.Extend(box);
      end = begin;
    }
    // Both ends give way as far as a step between them lies outside.
    for (int axis = 0; axis < 3; ++axis) {
      float below = 0, above = 0;
      for (uint32_t step = 1; step + 1 < steps; ++step) {
        const float time = static_cast<float>(step) / static_cast<float>(steps - 1);
        const float lower = Interpolate(begin.lower[axis], end.lower[axis], time);
        const float upper = Interpolate(begin.upper[axis], end.upper[axis], time);
        below = std::min(below, boxes[step].lower[axis] - lower);
        above = std::max(above, boxes[step].upper[axis] - upper);
      }
      begin.lower[axis] += below;
      end.lower[axis] += below;
      begin.upper[axis] += above;
      end.upper[axis] += above;
    }
    first.Extend(begin);
    last.Extend(end);
  }
  return {ToBounds(first), ToBounds(last)};
}

}  // namespace dacrt
