// A scene as one library holds it, committed and timed.
#pragma once

#include <span>
#include <vector>

#include "embree_library.h"
#include "ray_call.h"
#include "scene_content.h"

namespace dacrt::bench {

/// Which of Embree's builders makes the tree. The drop-in has none, and takes any.
enum class Build {
  kMedium,
  kLow,         ///< scene of RTC_BUILD_QUALITY_LOW
  kLowDynamic,  ///< its geometries as well, and RTC_SCENE_FLAG_DYNAMIC: Embree's fastest
};

const char* Name(Build build);

class CommittedScene {
 public:
  /// Both must outlive this. Embree reads one float beyond the last vertex: it must be there.
  /// Throws std::runtime_error if the library reports an error.
  CommittedScene(const EmbreeLibrary& library, const SceneContent& content, Build build);
  ~CommittedScene();
  CommittedScene(const CommittedScene&) = delete;
  CommittedScene& operator=(const CommittedScene&) = delete;

  /// Of the scene and of those that it instances.
  double commit_seconds() const { return commit_seconds_; }

  /// Traces the rays, which must be armed. May be called from several threads.
  void Trace(Query query, const Call& call, std::span<RayRecord> rays) const {
    bench::Trace(library_.api(), scenes_.back(), query, call, rays);
  }

 private:
  RTCScene Make(const SceneContent& content, Build build);
  RTCGeometry Make(const GeometryContent& geometry, std::span<const RTCScene> instanced) const;
  void Release();

  const EmbreeLibrary& library_;
  std::vector<RTCScene> scenes_;  ///< the instanced ones first
  double commit_seconds_ = 0;
};

}  // namespace dacrt::bench
