// Scenes and settings over which something once was many times slower than elsewhere. Each cliff
// that is found comes here.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "embree_scene.h"

namespace dacrt::bench {

/// One mesh, in the scene itself or seen through instances of it.
struct CliffContent {
  std::vector<tests::Float3> vertices;
  std::vector<tests::Triangle> triangles;
  std::vector<tests::Float3>
      instances;  ///< where they stand; none: the mesh itself is in the scene
  RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;  ///< of the scene that the mesh is in
  bool has_filter = false;                    ///< one that accepts every hit
  unsigned int steps = 1;  ///< time steps of the mesh, at which it stands higher and higher
};

struct CliffCase {
  const char* name;
  const char* what;
  double budget;  ///< dacrt_budget in bytes a triangle; 0: its default
  CliffContent (*make)();
  bool is_lit = false;  ///< by rays to a lamp from what a picture shows, not by rays from anywhere
};

const std::vector<CliffCase>& CliffCases();

/// What is_lit stands between 0 and this height over the unit square.
inline constexpr float kSpikeHeight = 0.015f;

/// A content as one library holds it, committed.
class CliffScene {
 public:
  /// Both must outlive this. Throws std::runtime_error if the library reports an error.
  CliffScene(const tests::EmbreeDevice& device, const CliffContent& content);
  ~CliffScene();
  CliffScene(const CliffScene&) = delete;
  CliffScene& operator=(const CliffScene&) = delete;

  const tests::EmbreeApi& api() const { return device_.api(); }
  RTCScene handle() const { return top_; }

 private:
  const tests::EmbreeDevice& device_;
  RTCScene inner_, top_;
};

}  // namespace dacrt::bench
