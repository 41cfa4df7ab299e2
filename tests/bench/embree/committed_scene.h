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
  kHigh,        ///< scene of RTC_BUILD_QUALITY_HIGH, with spatial splits: for rays alone
  kLow,         ///< scene of RTC_BUILD_QUALITY_LOW
  kLowDynamic,  ///< its geometries as well, and RTC_SCENE_FLAG_DYNAMIC: Embree's fastest
  kRefit,       ///< the same with geometries of RTC_BUILD_QUALITY_REFIT: only vertices may change
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

  /// Of the scene and of those that it instances; of the last Recommit, when there was one.
  double commit_seconds() const { return commit_seconds_; }

  /// Tells the library what has changed in the content, and commits the scene again. Throws as the
  /// constructor.
  void Recommit(const SceneContent& content, const ContentChange& change);

  /// Traces the rays, which must be armed. May be called from several threads.
  void Trace(Query query, const Call& call, std::span<RayRecord> rays) const {
    bench::Trace(library_.api(), scene_, query, call, rays);
  }

 private:
  RTCScene NewScene(const SceneContent& content) const;
  RTCGeometry NewGeometry(const GeometryContent& content) const;
  void Commit(RTCScene scene, std::span<const RTCGeometry> geometries);
  void Replace(unsigned id, const GeometryContent& content);
  void Release();

  const EmbreeLibrary& library_;
  const Build build_;
  std::vector<RTCScene> instanced_;
  RTCScene scene_ = nullptr;
  std::vector<RTCGeometry> geometries_;  ///< of the scene
  double commit_seconds_ = 0;
};

}  // namespace dacrt::bench
