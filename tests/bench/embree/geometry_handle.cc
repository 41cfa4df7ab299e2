#include "geometry_handle.h"

#include "callbacks.h"

namespace dacrt::bench {
namespace {

// How the arrays of a type of geometry are to be read.
struct Layout {
  RTCFormat vertex_format;
  std::size_t vertex_bytes;
  RTCBufferType primitives;
  RTCFormat primitive_format;
  std::size_t primitive_bytes;
};

Layout LayoutOf(RTCGeometryType type) {
  constexpr std::size_t kFloat3 = 3 * sizeof(float);
  switch (type) {
    case RTC_GEOMETRY_TYPE_QUAD:
      return {RTC_FORMAT_FLOAT3, kFloat3, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4, 16};
    case RTC_GEOMETRY_TYPE_GRID:
      return {RTC_FORMAT_FLOAT3, kFloat3, RTC_BUFFER_TYPE_GRID, RTC_FORMAT_GRID, sizeof(RTCGrid)};
    case RTC_GEOMETRY_TYPE_SPHERE_POINT:
      return {RTC_FORMAT_FLOAT4, 4 * sizeof(float), {}, {}, 0};
    default:
      return {RTC_FORMAT_FLOAT3, kFloat3, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12};
  }
}

}  // namespace

RTCGeometry MakeGeometry(const EmbreeLibrary& library, const GeometryContent& content,
                         std::span<const RTCScene> instanced) {
  const tests::EmbreeApi& api = library.api();
  const RTCGeometry geometry = api.rtcNewGeometry(library.device().handle(), content.type);
  api.rtcSetGeometryMask(geometry, content.mask);
  if (content.type == RTC_GEOMETRY_TYPE_INSTANCE) {
    api.rtcSetGeometryInstancedScene(geometry, instanced[content.scene]);
    SetTransform(library, geometry, content);
    return geometry;
  }
  if (content.type == RTC_GEOMETRY_TYPE_USER) {
    SetSphereFunctions(api, geometry, content.user);
    return geometry;
  }
  const Layout layout = LayoutOf(content.type);
  api.rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(content.vertices.size()));
  for (unsigned step = 0; step < content.vertices.size(); ++step) {
    api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, layout.vertex_format,
                                   content.vertices[step], 0, layout.vertex_bytes,
                                   content.vertex_count);
  }
  if (content.primitives) SetPrimitives(library, geometry, content);
  if (content.is_filtered) SetFilterFunctions(api, geometry);
  return geometry;
}

void SetPrimitives(const EmbreeLibrary& library, RTCGeometry geometry,
                   const GeometryContent& content) {
  const Layout layout = LayoutOf(content.type);
  library.api().rtcSetSharedGeometryBuffer(geometry, layout.primitives, 0, layout.primitive_format,
                                           content.primitives, 0, layout.primitive_bytes,
                                           content.primitive_count);
}

void SetTransform(const EmbreeLibrary& library, RTCGeometry geometry,
                  const GeometryContent& content) {
  library.api().rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                        content.transform.data());
}

}  // namespace dacrt::bench
