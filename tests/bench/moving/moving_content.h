// Scenes that change from frame to frame.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "bench_scene.h"
#include "scene_content.h"

namespace dacrt::bench {

/// A scene's content in memory that all libraries share, and what changes in it.
class MovingContent {
 public:
  virtual ~MovingContent() = default;

  /// Goes on to the next frame: writes the arrays. Every scene that is made of the content must be
  /// committed again before rays are sent to it.
  void Advance() { Show(++frame_); }

  const SceneContent& content() const { return content_; }

  /// What each frame changes.
  const ContentChange& change() const { return change_; }

 protected:
  explicit MovingContent(const ContentChange& change) : change_(change) {}

  virtual void Show(int frame) = 0;

  SceneContent content_;
  ContentChange change_;

 private:
  int frame_ = 0;
};

struct ChangeKind {
  const char* name;
  bool can_refit;  ///< only vertices move, as Embree's refitting asks
  std::unique_ptr<MovingContent> (*make)(const BenchScene& scene);
};

/// wave (all vertices of one mesh move), one-of-1000 (one mesh of a thousand moves), instances (a
/// thousand, all of which turn), growing (a mesh has more triangles each frame, in another index
/// buffer), replaced (another mesh each frame). The content refers to the mesh of the scene, which
/// must outlive it.
std::span<const ChangeKind> ChangeKinds();

/// Null if there is none of this name.
const ChangeKind* FindChangeKind(const std::string& name);

}  // namespace dacrt::bench
