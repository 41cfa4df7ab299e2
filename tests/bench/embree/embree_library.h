// One of the two libraries with Embree's interface, and a scene in it, timed.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <span>
#include <string>

#include "bench_scene.h"
#include "embree_api.h"
#include "embree_scene.h"
#include "ray_buffer.h"

namespace dacrt::bench {

/// How a program hands over its rays.
enum class Call { kCoherentStream, kIncoherentStream, kSingleRays };

const char* Name(Call call);

/// A device of a library.
///
/// Devices of Embree that are there at the same time must be for the same number of threads: it
/// gives all of them as many as the largest may have. The number holds for what the other library
/// does with TBB, too, because both use the one TBB of the process.
class EmbreeLibrary {
 public:
  /// `path` contains a slash, and `config` is for rtcNewDevice.
  /// Throws std::runtime_error if the library cannot be had.
  EmbreeLibrary(const std::string& path, const std::string& config);

  const tests::EmbreeApi& api() const { return *api_; }
  const tests::EmbreeDevice& device() const { return *device_; }

 private:
  std::unique_ptr<tests::EmbreeApi> api_;
  std::unique_ptr<tests::EmbreeDevice> device_;
};

/// The mesh of a benchmark's scene, shared with the library.
class CommittedScene {
 public:
  /// Both must outlive this. Embree reads one float beyond the last vertex: it must be there.
  /// Throws std::runtime_error if the library reports an error.
  CommittedScene(const EmbreeLibrary& library, const BenchScene& scene, RTCBuildQuality quality);
  ~CommittedScene();
  CommittedScene(const CommittedScene&) = delete;
  CommittedScene& operator=(const CommittedScene&) = delete;

  double commit_seconds() const { return commit_seconds_; }

  /// Traces the rays, which must be armed. May be called from several threads.
  void Trace(Query query, Call call, std::span<RayRecord> rays) const;

 private:
  const EmbreeLibrary& library_;
  RTCScene scene_;
  double commit_seconds_ = 0;
};

}  // namespace dacrt::bench
