#include "committed_scene.h"

#include "callbacks.h"
#include "timing.h"

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

const char* Name(Build build) {
  switch (build) {
    case Build::kMedium:
      return "medium";
    case Build::kLow:
      return "low";
    case Build::kLowDynamic:
      return "low dynamic";
  }
  return "";
}

CommittedScene::CommittedScene(const EmbreeLibrary& library, const SceneContent& content,
                               Build build)
    : library_(library) {
  for (const SceneContent& instanced : content.instanced) Make(instanced, build);
  Make(content, build);
  try {
    library.device().CheckErrors();
  } catch (...) {
    Release();
    throw;
  }
}

CommittedScene::~CommittedScene() { Release(); }

RTCScene CommittedScene::Make(const SceneContent& content, Build build) {
  const tests::EmbreeApi& api = library_.api();
  const std::vector<RTCScene> instanced = scenes_;
  const RTCScene scene = scenes_.emplace_back(api.rtcNewScene(library_.device().handle()));
  const int dynamic = build == Build::kLowDynamic ? RTC_SCENE_FLAG_DYNAMIC : 0;
  api.rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(content.flags | dynamic));
  api.rtcSetSceneBuildQuality(
      scene, build == Build::kMedium ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_LOW);
  std::vector<RTCGeometry> geometries;
  for (const GeometryContent& geometry : content.geometries) {
    geometries.push_back(Make(geometry, instanced));
    if (dynamic) api.rtcSetGeometryBuildQuality(geometries.back(), RTC_BUILD_QUALITY_LOW);
  }
  const Stopwatch stopwatch;
  for (unsigned id = 0; id < geometries.size(); ++id) {
    api.rtcCommitGeometry(geometries[id]);
    api.rtcAttachGeometryByID(scene, geometries[id], id);
  }
  api.rtcCommitScene(scene);
  commit_seconds_ += stopwatch.Seconds();
  for (const RTCGeometry geometry : geometries) api.rtcReleaseGeometry(geometry);
  return scene;
}

RTCGeometry CommittedScene::Make(const GeometryContent& content,
                                 std::span<const RTCScene> instanced) const {
  const tests::EmbreeApi& api = library_.api();
  const RTCGeometry geometry = api.rtcNewGeometry(library_.device().handle(), content.type);
  api.rtcSetGeometryMask(geometry, content.mask);
  if (content.type == RTC_GEOMETRY_TYPE_INSTANCE) {
    api.rtcSetGeometryInstancedScene(geometry, instanced[content.scene]);
    api.rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                content.transform.data());
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
  if (content.primitives) {
    api.rtcSetSharedGeometryBuffer(geometry, layout.primitives, 0, layout.primitive_format,
                                   content.primitives, 0, layout.primitive_bytes,
                                   content.primitive_count);
  }
  if (content.is_filtered) SetFilterFunctions(api, geometry);
  return geometry;
}

void CommittedScene::Release() {
  for (const RTCScene scene : scenes_) library_.api().rtcReleaseScene(scene);
}

}  // namespace dacrt::bench
