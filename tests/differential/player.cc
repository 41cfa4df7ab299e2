#include "player.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace dacrt::tests {
namespace {

/// What lies between the items of an array, which no library may take for data.
constexpr int kGapPattern = 0xff;

/// Embree loads sixteen bytes at each vertex, also at the last one.
constexpr std::size_t kTail = 16;

/// What arrays begin at multiples of.
constexpr std::size_t kAlignment = 16;

std::size_t RoundUp(std::size_t size) { return (size + kAlignment - 1) / kAlignment * kAlignment; }

std::size_t VertexSize(Shape shape) { return HasFacets(shape) ? 12 : 16; }

template <typename Item>
std::vector<std::byte> Pack(const std::vector<Item>& items, std::size_t item_size) {
  std::vector<std::byte> bytes(items.size() * item_size);
  for (std::size_t i = 0; i < items.size(); ++i) {
    std::memcpy(bytes.data() + i * item_size, &items[i], item_size);
  }
  return bytes;
}

std::vector<std::byte> PackPrimitives(const WorldGeometry& geometry) {
  if (geometry.shape == Shape::kTriangles) return Pack(geometry.primitives, 12);
  if (geometry.shape == Shape::kQuads) return Pack(geometry.primitives, 16);
  std::vector<RTCGrid> grids;
  for (const auto& p : geometry.primitives) {
    grids.push_back(
        {p[0], p[1], static_cast<unsigned short>(p[2]), static_cast<unsigned short>(p[3])});
  }
  return Pack(grids, sizeof(RTCGrid));
}

RTCGeometryType TypeOf(Shape shape) {
  constexpr RTCGeometryType kTypes[kShapeCount] = {
      RTC_GEOMETRY_TYPE_TRIANGLE,   RTC_GEOMETRY_TYPE_QUAD,
      RTC_GEOMETRY_TYPE_GRID,       RTC_GEOMETRY_TYPE_SPHERE_POINT,
      RTC_GEOMETRY_TYPE_DISC_POINT, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT,
      RTC_GEOMETRY_TYPE_USER,       RTC_GEOMETRY_TYPE_INSTANCE};
  return kTypes[static_cast<uint32_t>(shape)];
}

/// Of a buffer that geometries of a scene share; when it is full they get another.
constexpr std::size_t kCommonSize = 1 << 16;

}  // namespace

PlayedWorld::PlayedWorld(const EmbreeDevice& device, const std::vector<WorldScene>& scenes)
    : device_(device), descriptions_(scenes), scenes_(scenes.size()) {
  try {
    for (std::size_t i = 0; i < scenes_.size(); ++i) MakeScene(i);
  } catch (...) {
    Release();
    throw;
  }
}

PlayedWorld::~PlayedWorld() { Release(); }

void PlayedWorld::Release() {
  for (auto scene = scenes_.rbegin(); scene != scenes_.rend(); ++scene) {
    for (const Geometry& geometry : scene->geometries) {
      if (geometry.handle) api().rtcReleaseGeometry(geometry.handle);
    }
    if (scene->handle) api().rtcReleaseScene(scene->handle);
  }
  for (const RTCBuffer buffer : buffers_) api().rtcReleaseBuffer(buffer);
}

void PlayedWorld::MakeScene(std::size_t i) {
  const WorldScene& description = descriptions_[i];
  Scene& scene = scenes_[i];
  scene.handle = api().rtcNewScene(device_.handle());
  api().rtcSetSceneFlags(scene.handle, description.flags);
  api().rtcSetSceneBuildQuality(scene.handle, description.quality);
  // In place for good: the library is given pointers to what they hold.
  scene.geometries.resize(description.geometries.size());
  for (std::size_t g = 0; g < scene.geometries.size(); ++g) {
    MakeGeometry(scene, description.geometries[g], scene.geometries[g]);
  }
  api().rtcCommitScene(scene.handle);
  device_.CheckErrors();
}

void PlayedWorld::MakeGeometry(Scene& scene, const WorldGeometry& description, Geometry& geometry) {
  geometry.data = {
      &api(), &description,
      description.traces_again ? scenes_[description.instanced_scene].handle : nullptr};
  const RTCGeometry handle = api().rtcNewGeometry(device_.handle(), TypeOf(description.shape));
  geometry.handle = handle;
  device_.CheckErrors();
  if (description.StepCount() > 1) {
    api().rtcSetGeometryTimeStepCount(handle, description.StepCount());
    api().rtcSetGeometryTimeRange(handle, description.time_begin, description.time_end);
  }
  api().rtcSetGeometryMask(handle, description.mask);
  api().rtcSetGeometryUserData(handle, &geometry.data);
  if (description.shape == Shape::kInstance) {
    SetInstance(description, geometry);
  } else {
    api().rtcSetGeometryBuildQuality(handle, description.quality);
    SetFilters(description, handle);
    if (description.shape == Shape::kUser) {
      api().rtcSetGeometryUserPrimitiveCount(handle, description.PrimitiveCount());
      api().rtcSetGeometryBoundsFunction(handle, BoundUserPrimitive, nullptr);
      api().rtcSetGeometryIntersectFunction(handle, IntersectUserPrimitive);
      api().rtcSetGeometryOccludedFunction(handle, OccludeUserPrimitive);
    } else {
      SetArrays(scene, description, geometry);
    }
  }
  api().rtcCommitGeometry(handle);
  if (!description.enabled) api().rtcDisableGeometry(handle);
  if (description.attached) api().rtcAttachGeometryByID(scene.handle, handle, description.id);
  device_.CheckErrors();
}

void PlayedWorld::SetFilters(const WorldGeometry& description, RTCGeometry geometry) {
  const auto function = [](FilterKind kind, RTCFilterFunctionN filter) {
    return kind == FilterKind::kNone ? nullptr : filter;
  };
  api().rtcSetGeometryIntersectFilterFunction(geometry,
                                              function(description.closest_filter, FilterClosest));
  api().rtcSetGeometryOccludedFilterFunction(geometry, function(description.any_filter, FilterAny));
}

void PlayedWorld::SetArrays(Scene& scene, const WorldGeometry& description, Geometry& geometry) {
  geometry.vertices.clear();
  const std::size_t vertex_size = VertexSize(description.shape);
  const RTCFormat vertex_format = vertex_size == 12 ? RTC_FORMAT_FLOAT3 : RTC_FORMAT_FLOAT4;
  for (uint32_t step = 0; step < description.StepCount(); ++step) {
    geometry.vertices.push_back(
        SetArray(scene, description.layout, geometry.handle, RTC_BUFFER_TYPE_VERTEX, step,
                 vertex_format, Pack(description.vertices[step], vertex_size), vertex_size));
    if (description.shape == Shape::kOrientedDiscs) {
      SetArray(scene, description.layout, geometry.handle, RTC_BUFFER_TYPE_NORMAL, step,
               RTC_FORMAT_FLOAT3, Pack(description.normals[step], 12), 12);
    }
  }
  const std::vector<std::byte> primitives = PackPrimitives(description);
  switch (description.shape) {
    case Shape::kTriangles:
      SetArray(scene, description.layout, geometry.handle, RTC_BUFFER_TYPE_INDEX, 0,
               RTC_FORMAT_UINT3, primitives, 12);
      return;
    case Shape::kQuads:
      SetArray(scene, description.layout, geometry.handle, RTC_BUFFER_TYPE_INDEX, 0,
               RTC_FORMAT_UINT4, primitives, 16);
      return;
    case Shape::kGrids:
      SetArray(scene, description.layout, geometry.handle, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID,
               primitives, sizeof(RTCGrid));
      return;
    default:
      return;
  }
}

PlayedWorld::Array PlayedWorld::SetArray(Scene& scene, const ArrayLayout& layout,
                                         RTCGeometry geometry, RTCBufferType type, uint32_t slot,
                                         RTCFormat format, std::span<const std::byte> items,
                                         std::size_t item_size) {
  const std::size_t stride = item_size + layout.gap;
  const std::size_t count = items.size() / item_size;
  const std::size_t size = layout.offset + count * stride + kTail;
  Array array{nullptr, stride};
  switch (layout.memory) {
    case Memory::kShared:
      shared_.push_back(std::make_unique<std::byte[]>(size));
      std::memset(shared_.back().get(), kGapPattern, size);
      array.first = shared_.back().get() + layout.offset;
      api().rtcSetSharedGeometryBuffer(geometry, type, slot, format, shared_.back().get(),
                                       layout.offset, stride, count);
      break;
    case Memory::kNew:
      array.first = static_cast<std::byte*>(
          api().rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count));
      break;
    case Memory::kBuffer: {
      const RTCBuffer buffer = api().rtcNewBuffer(device_.handle(), size);
      buffers_.push_back(buffer);
      array.first = DataOf(buffer, layout.offset);
      api().rtcSetGeometryBuffer(geometry, type, slot, format, buffer, layout.offset, stride,
                                 count);
      break;
    }
    case Memory::kSceneBuffer: {
      if (scene.common_size + size > scene.common_capacity) {
        scene.common_capacity = std::max(kCommonSize, size);
        scene.common_size = 0;
        scene.common_buffer = api().rtcNewBuffer(device_.handle(), scene.common_capacity);
        buffers_.push_back(scene.common_buffer);
      }
      const std::size_t offset = scene.common_size + layout.offset;
      array.first = DataOf(scene.common_buffer, offset);
      api().rtcSetGeometryBuffer(geometry, type, slot, format, scene.common_buffer, offset, stride,
                                 count);
      scene.common_size += RoundUp(size);
    }
  }
  device_.CheckErrors();
  for (std::size_t i = 0; i < count; ++i) {
    std::memcpy(array.first + i * stride, items.data() + i * item_size, item_size);
  }
  return array;
}

void PlayedWorld::SetInstance(const WorldGeometry& description, const Geometry& geometry) {
  api().rtcSetGeometryInstancedScene(geometry.handle, scenes_[description.instanced_scene].handle);
  SetPlacements(description, geometry.handle);
}

void PlayedWorld::SetPlacements(const WorldGeometry& description, RTCGeometry geometry) {
  for (uint32_t step = 0; step < description.StepCount(); ++step) {
    const Placement& placement = description.placements[step];
    if (description.in_parts) {
      RTCQuaternionDecomposition parts;
      static_assert(sizeof(parts) == sizeof(placement.parts));
      std::memcpy(&parts, placement.parts.data(), sizeof(parts));
      api().rtcSetGeometryTransformQuaternion(geometry, step, &parts);
      continue;
    }
    const auto& m = placement.matrix;
    const float columns4[16] = {m[0], m[1], m[2], 0, m[3], m[4],  m[5],  0,
                                m[6], m[7], m[8], 0, m[9], m[10], m[11], 1};
    const float rows[12] = {m[0], m[3],  m[6], m[9], m[1], m[4],
                            m[7], m[10], m[2], m[5], m[8], m[11]};
    const float* const values =
        description.transform_format == RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR ? m.data()
        : description.transform_format == RTC_FORMAT_FLOAT3X4_ROW_MAJOR  ? rows
                                                                         : columns4;
    api().rtcSetGeometryTransform(geometry, step, description.transform_format, values);
  }
  device_.CheckErrors();
}

std::byte* PlayedWorld::DataOf(RTCBuffer buffer, std::size_t offset) const {
  auto* const data = static_cast<std::byte*>(api().rtcGetBufferData(buffer));
  return data ? data + offset : nullptr;
}

void PlayedWorld::WriteVertices(const WorldGeometry& description, Geometry& geometry) {
  if (description.shape == Shape::kUser) return;  // The callbacks read the description.
  const std::size_t size = VertexSize(description.shape);
  for (uint32_t step = 0; step < description.StepCount(); ++step) {
    const Array& array = geometry.vertices[step];
    for (std::size_t i = 0; i < description.vertices[step].size(); ++i) {
      std::memcpy(array.first + i * array.stride, &description.vertices[step][i], size);
    }
    api().rtcUpdateGeometryBuffer(geometry.handle, RTC_BUFFER_TYPE_VERTEX, step);
  }
}

void PlayedWorld::Play(const Change& change) {
  Apply(change, descriptions_);
  Scene& scene = scenes_[change.scene];
  const WorldGeometry& description = descriptions_[change.scene].geometries[change.geometry];
  Geometry& geometry = scenes_[change.scene].geometries[change.geometry];
  switch (change.kind) {
    case Change::Kind::kEnable:
      return api().rtcEnableGeometry(geometry.handle);
    case Change::Kind::kDisable:
      return api().rtcDisableGeometry(geometry.handle);
    case Change::Kind::kDetach:
      return api().rtcDetachGeometry(scene.handle, description.id);
    case Change::Kind::kAttach:
      return api().rtcAttachGeometryByID(scene.handle, geometry.handle, description.id);
    case Change::Kind::kReplace:
      if (description.attached) api().rtcDetachGeometry(scene.handle, description.id);
      api().rtcReleaseGeometry(std::exchange(geometry.handle, nullptr));
      return MakeGeometry(scene, description, geometry);
    case Change::Kind::kMask:
      api().rtcSetGeometryMask(geometry.handle, change.mask);
      return api().rtcCommitGeometry(geometry.handle);
    case Change::Kind::kShift:
      if (description.shape == Shape::kInstance) {
        SetPlacements(description, geometry.handle);
      } else {
        WriteVertices(description, geometry);
      }
      return api().rtcCommitGeometry(geometry.handle);
    case Change::Kind::kBend:
    case Change::Kind::kScatter:
    case Change::Kind::kSpoil:
      if (description.shape != Shape::kInstance) WriteVertices(description, geometry);
      return api().rtcCommitGeometry(geometry.handle);
    case Change::Kind::kFilters:
      if (description.shape != Shape::kInstance) SetFilters(description, geometry.handle);
      return api().rtcCommitGeometry(geometry.handle);
    case Change::Kind::kPrimitives:
      if (description.shape == Shape::kUser) {
        api().rtcSetGeometryUserPrimitiveCount(geometry.handle, description.PrimitiveCount());
      } else if (description.shape != Shape::kInstance) {
        SetArrays(scene, description, geometry);
      }
      return api().rtcCommitGeometry(geometry.handle);
  }
}

void PlayedWorld::Commit(std::span<const Change> changes) {
  std::vector<bool> is_changed(scenes_.size());
  for (const Change& change : changes) {
    Play(change);
    is_changed[change.scene] = true;
    device_.CheckErrors();
  }
  for (std::size_t i = 0; i < scenes_.size(); ++i) {
    for (std::size_t g = 0; g < scenes_[i].geometries.size(); ++g) {
      const WorldGeometry& geometry = descriptions_[i].geometries[g];
      if (geometry.shape != Shape::kInstance || !is_changed[geometry.instanced_scene]) continue;
      api().rtcCommitGeometry(scenes_[i].geometries[g].handle);
      is_changed[i] = true;
    }
    if (is_changed[i]) api().rtcCommitScene(scenes_[i].handle);
    device_.CheckErrors();
  }
}

std::vector<RTCRayHit> PlayedWorld::Trace(const Batch& batch, std::span<const RTCRayHit> rays,
                                          CallContext& call) const {
  std::vector<RTCRayHit> result;
  result.reserve(rays.size());
  const RTCScene scene = scenes_.back().handle;
  while (!rays.empty()) {
    const std::size_t count = std::min<std::size_t>(batch.rays_per_call, rays.size());
    const std::vector<RTCRayHit> piece =
        tests::Trace(api(), scene, call.context, batch.form, batch.query, rays.first(count));
    result.insert(result.end(), piece.begin(), piece.end());
    rays = rays.subspan(count);
  }
  return result;
}

RTCBounds PlayedWorld::Bounds() const {
  RTCBounds bounds;
  api().rtcGetSceneBounds(scenes_.back().handle, &bounds);
  return bounds;
}

}  // namespace dacrt::tests
