#include "committed_scene.h"

#include "geometry_handle.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

bool IsDynamic(Build build) { return build == Build::kLowDynamic || build == Build::kRefit; }

RTCBuildQuality QualityOf(Build build) {
  switch (build) {
    case Build::kMedium:
      return RTC_BUILD_QUALITY_MEDIUM;
    case Build::kHigh:
      return RTC_BUILD_QUALITY_HIGH;
    default:
      return RTC_BUILD_QUALITY_LOW;
  }
}

}  // namespace

const char* Name(Build build) {
  switch (build) {
    case Build::kMedium:
      return "medium";
    case Build::kHigh:
      return "high";
    case Build::kLow:
      return "low";
    case Build::kLowDynamic:
      return "low dynamic";
    case Build::kRefit:
      return "refit";
  }
  return "";
}

CommittedScene::CommittedScene(const EmbreeLibrary& library, const SceneContent& content,
                               Build build)
    : library_(library), build_(build) {
  for (const SceneContent& part : content.instanced) {
    std::vector<RTCGeometry> geometries;
    for (const GeometryContent& geometry : part.geometries) {
      geometries.push_back(NewGeometry(geometry));
    }
    Commit(instanced_.emplace_back(NewScene(part)), geometries);
    for (const RTCGeometry geometry : geometries) library.api().rtcReleaseGeometry(geometry);
  }
  scene_ = NewScene(content);
  for (const GeometryContent& geometry : content.geometries) {
    geometries_.push_back(NewGeometry(geometry));
  }
  Commit(scene_, geometries_);
  try {
    library.device().CheckErrors();
  } catch (...) {
    Release();
    throw;
  }
}

CommittedScene::~CommittedScene() { Release(); }

RTCScene CommittedScene::NewScene(const SceneContent& content) const {
  const tests::EmbreeApi& api = library_.api();
  const RTCScene scene = api.rtcNewScene(library_.device().handle());
  const int dynamic = IsDynamic(build_) ? RTC_SCENE_FLAG_DYNAMIC : 0;
  api.rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(content.flags | dynamic));
  api.rtcSetSceneBuildQuality(scene, QualityOf(build_));
  return scene;
}

RTCGeometry CommittedScene::NewGeometry(const GeometryContent& content) const {
  const RTCGeometry geometry = MakeGeometry(library_, content, instanced_);
  if (IsDynamic(build_)) {
    library_.api().rtcSetGeometryBuildQuality(
        geometry, build_ == Build::kRefit ? RTC_BUILD_QUALITY_REFIT : RTC_BUILD_QUALITY_LOW);
  }
  return geometry;
}

void CommittedScene::Commit(RTCScene scene, std::span<const RTCGeometry> geometries) {
  const tests::EmbreeApi& api = library_.api();
  const Stopwatch stopwatch;
  for (unsigned id = 0; id < geometries.size(); ++id) {
    api.rtcCommitGeometry(geometries[id]);
    api.rtcAttachGeometryByID(scene, geometries[id], id);
  }
  api.rtcCommitScene(scene);
  commit_seconds_ += stopwatch.Seconds();
}

void CommittedScene::Recommit(const SceneContent& content, const ContentChange& change) {
  const tests::EmbreeApi& api = library_.api();
  const Stopwatch stopwatch;
  for (std::size_t i = change.first; i < change.first + change.count; ++i) {
    const GeometryContent& changed = content.geometries[i];
    switch (change.of) {
      case ContentChange::Of::kVertices:
        api.rtcUpdateGeometryBuffer(geometries_[i], RTC_BUFFER_TYPE_VERTEX, 0);
        break;
      case ContentChange::Of::kPrimitives:
        SetPrimitives(library_, geometries_[i], changed);
        break;
      case ContentChange::Of::kTransform:
        SetTransform(library_, geometries_[i], changed);
        break;
      case ContentChange::Of::kAll:
        Replace(static_cast<unsigned>(i), changed);
        break;
    }
    api.rtcCommitGeometry(geometries_[i]);
  }
  api.rtcCommitScene(scene_);
  commit_seconds_ = stopwatch.Seconds();
  library_.device().CheckErrors();
}

void CommittedScene::Replace(unsigned id, const GeometryContent& content) {
  const tests::EmbreeApi& api = library_.api();
  api.rtcDetachGeometry(scene_, id);
  api.rtcReleaseGeometry(geometries_[id]);
  geometries_[id] = NewGeometry(content);
  api.rtcAttachGeometryByID(scene_, geometries_[id], id);
}

void CommittedScene::Release() {
  const tests::EmbreeApi& api = library_.api();
  for (const RTCGeometry geometry : geometries_) api.rtcReleaseGeometry(geometry);
  api.rtcReleaseScene(scene_);
  for (const RTCScene scene : instanced_) api.rtcReleaseScene(scene);
}

}  // namespace dacrt::bench
