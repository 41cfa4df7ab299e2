#include "scene_message.h"

#include <type_traits>

namespace dacrt::mpi {
namespace {

static_assert(std::is_trivially_copyable_v<Settings>);
static_assert(std::is_trivially_copyable_v<SceneOptions>);
static_assert(std::is_trivially_copyable_v<TransformStep>);

/// Of a geometry, what has a fixed size.
struct GeometryHead {
  uint32_t shape;
  uint32_t geometry_id;
  uint32_t mask;
  TimeRange time_range;
  uint64_t primitive_count;
  uint64_t vertex_count;
  uint64_t instanced_scene;
  uint64_t vertex_arrays, normal_arrays, transforms;
};

bool IsPoint(Shape shape) {
  return shape == Shape::kSpheres || shape == Shape::kDiscs || shape == Shape::kOrientedDiscs;
}

std::size_t VertexBytes(Shape shape) { return IsPoint(shape) ? 16 : 12; }

std::size_t PrimitiveBytes(Shape shape) {
  switch (shape) {
    case Shape::kTriangles:
      return 12;
    case Shape::kQuads:
      return 16;
    case Shape::kGrids:
      return sizeof(GridPrimitive);
    default:
      return 0;
  }
}

/// Sees every array of `geometry`, in the order in which they travel, with its count and the bytes
/// of an item.
template <class AnyGeometry, class See>
void ForEachArray(AnyGeometry& geometry, const See& see) {
  const Shape shape = geometry.shape;
  for (auto& array : geometry.vertices) see(array, geometry.vertex_count, VertexBytes(shape));
  for (auto& array : geometry.normals) see(array, geometry.vertex_count, std::size_t{12});
  if (PrimitiveBytes(shape) > 0) {
    see(geometry.primitives, geometry.primitive_count, PrimitiveBytes(shape));
  }
}

}  // namespace

bool CanTravel(const Geometry& geometry) {
  return geometry.shape != Shape::kUser && !geometry.closest_filter && !geometry.any_filter;
}

std::optional<PackedScene> PackScene(uint64_t number, const LocalScene& local,
                                     std::span<const Geometry> geometries,
                                     const SceneOptions& options, const SceneNumber& number_of) {
  PackedScene packed;
  Message& message = packed.message;
  message.Put(number);
  Settings settings = local.settings;
  settings.instruction_set = local.instruction_set;  // the same bits everywhere
  message.Put(settings);
  message.Put(options);
  message.Put(static_cast<uint64_t>(geometries.size()));
  for (const Geometry& geometry : geometries) {
    if (!CanTravel(geometry)) return std::nullopt;
    uint64_t instanced_scene = 0;
    if (geometry.shape == Shape::kInstance) {
      const auto known = number_of(geometry.instanced_scene.get());
      if (!known) return std::nullopt;
      instanced_scene = *known;
    }
    message.Put(GeometryHead{static_cast<uint32_t>(geometry.shape), geometry.geometry_id,
                             geometry.mask, geometry.time_range, geometry.primitive_count,
                             geometry.vertex_count, instanced_scene, geometry.vertices.size(),
                             geometry.normals.size(), geometry.transforms.size()});
    for (const TransformStep& transform : geometry.transforms) message.Put(transform);
    ForEachArray(geometry, [&](const Array& array, std::size_t count, std::size_t item_bytes) {
      packed.arrays.push_back({array, array.data ? count : 0, item_bytes});
      packed.names.push_back(NameOf(packed.arrays.back()));
      message.Put(packed.names.back());
    });
  }
  return packed;
}

UnpackedScene UnpackScene(Reader& reader, const FindArray& find_array,
                          const FindScene& find_scene) {
  UnpackedScene scene;
  scene.number = reader.Take<uint64_t>();
  scene.settings = reader.Take<Settings>();
  scene.options = reader.Take<SceneOptions>();
  const auto count = reader.Take<uint64_t>();
  for (uint64_t i = 0; i < count; ++i) {
    const auto head = reader.Take<GeometryHead>();
    Geometry& geometry = scene.geometries.emplace_back();
    geometry.shape = static_cast<Shape>(head.shape);
    geometry.geometry_id = head.geometry_id;
    geometry.mask = head.mask;
    geometry.time_range = head.time_range;
    geometry.primitive_count = head.primitive_count;
    geometry.vertex_count = head.vertex_count;
    if (geometry.shape == Shape::kInstance) {
      geometry.instanced_scene = find_scene(head.instanced_scene);
    }
    for (uint64_t step = 0; step < head.transforms; ++step) {
      geometry.transforms.push_back(reader.Take<TransformStep>());
    }
    geometry.vertices.resize(head.vertex_arrays);
    geometry.normals.resize(head.normal_arrays);
    ForEachArray(geometry, [&](Array& array, std::size_t, std::size_t item_bytes) {
      const auto name = reader.Take<ArrayName>();
      if (name.bytes == 0) return;
      auto data = find_array(name);
      array = {data.get(), item_bytes};
      scene.used.push_back(std::move(data));
    });
  }
  reader.ExpectEnd();
  return scene;
}

}  // namespace dacrt::mpi
