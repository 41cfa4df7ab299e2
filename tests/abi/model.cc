#include "model.h"

#include <algorithm>
#include <array>
#include <limits>
#include <random>

namespace dacrt::tests {

std::string NameOf(RTCGeometryType type) {
  switch (type) {
    case RTC_GEOMETRY_TYPE_TRIANGLE:
      return "triangle";
    case RTC_GEOMETRY_TYPE_QUAD:
      return "quad";
    case RTC_GEOMETRY_TYPE_GRID:
      return "grid";
    case RTC_GEOMETRY_TYPE_SPHERE_POINT:
      return "sphere";
    case RTC_GEOMETRY_TYPE_DISC_POINT:
      return "disc";
    case RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT:
      return "oriented_disc";
    case RTC_GEOMETRY_TYPE_USER:
      return "user";
    case RTC_GEOMETRY_TYPE_INSTANCE:
      return "instance";
    default:
      return "type_" + std::to_string(type);
  }
}

bool IsPoint(RTCGeometryType type) {
  return type == RTC_GEOMETRY_TYPE_SPHERE_POINT || type == RTC_GEOMETRY_TYPE_DISC_POINT ||
         type == RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT;
}

bool HasBuffers(RTCGeometryType type) {
  return type != RTC_GEOMETRY_TYPE_USER && type != RTC_GEOMETRY_TYPE_INSTANCE;
}

namespace {

/// A new buffer of zeros, whose item i starts at float i * stride / 4.
float* NewItems(Session& s, RTCGeometry geometry, RTCBufferType type, unsigned int slot,
                RTCFormat format, std::size_t stride, std::size_t count) {
  auto* const items = static_cast<float*>(
      s.api.rtcSetNewGeometryBuffer(geometry, type, slot, format, stride, count));
  std::fill_n(items, stride / sizeof(float) * count, 0.0f);
  return items;
}

}  // namespace

void SetVertices(Session& s, RTCGeometry geometry, RTCGeometryType type, unsigned int slot, float z,
                 std::size_t count, std::size_t gap) {
  const bool is_point = IsPoint(type);
  const std::size_t stride = (is_point ? 16 : 12) + gap;
  float* const vertices = NewItems(s, geometry, RTC_BUFFER_TYPE_VERTEX, slot,
                                   is_point ? RTC_FORMAT_FLOAT4 : RTC_FORMAT_FLOAT3, stride, count);
  // Round the square; a grid's are in rows.
  const bool is_grid = type == RTC_GEOMETRY_TYPE_GRID;
  const float corners[4][2] = {
      {0, 0}, {1, 0}, {is_grid ? 0.0f : 1.0f, 1}, {is_grid ? 1.0f : 0.0f, 1}};
  for (std::size_t i = 0; i < std::min<std::size_t>(count, 4); ++i) {
    float* const vertex = vertices + i * stride / sizeof(float);
    vertex[0] = corners[i][0];
    vertex[1] = corners[i][1];
    vertex[2] = z;
    if (is_point) vertex[3] = 1;
  }
  if (type != RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT) return;
  float* const normals =
      NewItems(s, geometry, RTC_BUFFER_TYPE_NORMAL, slot, RTC_FORMAT_FLOAT3, 12 + gap, count);
  for (std::size_t i = 0; i < count; ++i) normals[i * (12 + gap) / sizeof(float) + 2] = 1;
}

void SetPrimitives(Session& s, RTCGeometry geometry, RTCGeometryType type, std::size_t count) {
  if (type == RTC_GEOMETRY_TYPE_GRID) {
    auto* const grids = static_cast<RTCGrid*>(s.api.rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), count));
    std::fill_n(grids, count, RTCGrid{0, 2, 2, 2});
    return;
  }
  if (type != RTC_GEOMETRY_TYPE_TRIANGLE && type != RTC_GEOMETRY_TYPE_QUAD) return;
  const bool is_quad = type == RTC_GEOMETRY_TYPE_QUAD;
  using Corners = std::array<unsigned int, 4>;
  auto* const indices = static_cast<Corners*>(s.api.rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, is_quad ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
      sizeof(Corners), count));
  std::fill_n(indices, count, is_quad ? Corners{0, 1, 2, 3} : Corners{0, 1, 3, 0});
}

RTCGeometry UncommittedModel(Session& s, RTCGeometryType type) {
  if (type == RTC_GEOMETRY_TYPE_INSTANCE) return Instance(s, s.SceneOf(s.Triangle()));
  const RTCGeometry geometry = s.Own(s.api.rtcNewGeometry(s.device, type));
  if (type == RTC_GEOMETRY_TYPE_USER) {
    s.api.rtcSetGeometryUserPrimitiveCount(geometry, 1);
    s.api.rtcSetGeometryBoundsFunction(geometry, BoundUnitBox, nullptr);
    s.api.rtcSetGeometryIntersectFunction(geometry, IntersectPlane);
    s.api.rtcSetGeometryOccludedFunction(geometry, OccludePlane);
    return geometry;
  }
  SetVertices(s, geometry, type, 0);
  SetPrimitives(s, geometry, type);
  return geometry;
}

RTCGeometry Model(Session& s, RTCGeometryType type) {
  const RTCGeometry geometry = UncommittedModel(s, type);
  s.api.rtcCommitGeometry(geometry);
  return geometry;
}

RTCGeometry UncommittedSoup(Session& s, unsigned int seed, unsigned int count, float size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  const RTCGeometry geometry = s.NewGeometry();
  auto* const vertices = static_cast<float*>(s.api.rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count));
  auto* const indices = static_cast<unsigned int*>(s.api.rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
  for (unsigned int triangle = 0; triangle < count; ++triangle) {
    const float corner[3] = {unit(random), unit(random), unit(random)};
    for (unsigned int i = 0; i < 9; ++i) {
      vertices[9 * triangle + i] = corner[i % 3] + size * unit(random);
    }
    for (unsigned int i = 0; i < 3; ++i) indices[3 * triangle + i] = 3 * triangle + i;
  }
  return geometry;
}

std::vector<RTCRayHit> RandomRays(unsigned int seed, std::size_t count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<RTCRayHit> rays(count, RayAt(0));
  for (RTCRayHit& record : rays) {
    record.ray.org_x = unit(random);
    record.ray.org_y = unit(random);
    record.ray.org_z = -1;
    record.ray.dir_x = unit(random) - 0.5f;
    record.ray.dir_y = unit(random) - 0.5f;
  }
  return rays;
}

void BoundUnitBox(const RTCBoundsFunctionArguments* args) {
  *args->bounds_o = {0, 0, 0, 0, 1, 1, 1, 0};
}

void IntersectPlane(const RTCIntersectFunctionNArguments* args) {
  RTCRayN* const ray = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* const hit = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned int i = 0; i < args->N; ++i) {
    const float t = -RTCRayN_org_z(ray, args->N, i) / RTCRayN_dir_z(ray, args->N, i);
    float& tfar = RTCRayN_tfar(ray, args->N, i);
    if (!args->valid[i] || !(t > RTCRayN_tnear(ray, args->N, i) && t < tfar)) continue;
    tfar = t;
    RTCHitN_u(hit, args->N, i) = 0.5f;
    RTCHitN_v(hit, args->N, i) = 0;
    RTCHitN_geomID(hit, args->N, i) = args->geomID;
    RTCHitN_primID(hit, args->N, i) = args->primID;
    RTCHitN_instID(hit, args->N, i, 0) = args->context->instID[0];
  }
}

void OccludePlane(const RTCOccludedFunctionNArguments* args) {
  for (unsigned int i = 0; i < args->N; ++i) {
    const float t = -RTCRayN_org_z(args->ray, args->N, i) / RTCRayN_dir_z(args->ray, args->N, i);
    float& tfar = RTCRayN_tfar(args->ray, args->N, i);
    if (args->valid[i] && t > RTCRayN_tnear(args->ray, args->N, i) && t < tfar) {
      tfar = -std::numeric_limits<float>::infinity();
    }
  }
}

RTCGeometry Instance(Session& s, RTCScene scene, float z) {
  const RTCGeometry instance = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_INSTANCE));
  s.api.rtcSetGeometryInstancedScene(instance, scene);
  const float matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, z};
  s.api.rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix);
  return instance;
}

}  // namespace dacrt::tests
