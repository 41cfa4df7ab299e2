// The drop-in against Embree on one scene that changes.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "delivery.h"
#include "moving_content.h"
#include "moving_results.h"
#include "ray_kind.h"

namespace dacrt::bench {

/// Both libraries on a scene with one kind of change, on a number of threads. Contests for
/// different numbers must not be there at the same time: see EmbreeLibrary.
///
/// A frame is what tells the library of the change, the commit, and one stream of rays. What the
/// program does to move its vertices is the same for both, and is not timed.
class MovingContest {
 public:
  /// `scene` must outlive this.
  MovingContest(const BenchScene& scene, const ChangeKind& change, int threads);

  using OnStep = std::function<void(const std::string& step)>;

  /// At least `repeat` frames of each library, in turn, after one that is not counted. Nothing if
  /// there are no such rays. Throws Disagreement (errors.h) if the hits are apart.
  std::optional<MovingResult> Measure(const MovingCell& cell, int repeat, const OnStep& on_step);

 private:
  // One library's scene; Embree's are one for each instruction set and builder.
  struct Entrant {
    Entrant(std::string name, const EmbreeLibrary& library, const SceneContent& content,
            Build build)
        : name(std::move(name)), scene(library, content, build) {}
    std::string name;
    CommittedScene scene;
  };
  // A way to use Embree.
  struct Candidate {
    Entrant* entrant;
    Delivery delivery;
    double seconds;  ///< of a frame, once
    FrameTimes times;
  };

  /// Of ways that differ in more than the call; none if there are no such rays.
  std::vector<Candidate> FindBest(const RayKind& kind, std::uint32_t side);
  /// Goes on to the next frame, of which no scene that is measured has been told yet.
  RayBuffer MakeFrame(const RayKind& kind, std::uint32_t side);
  void Recommit(Entrant& entrant) const;

  const BenchScene& scene_;
  const int threads_;
  std::unique_ptr<MovingContent> content_;
  std::deque<EmbreeLibrary> libraries_;
  std::deque<Entrant> embree_;
  std::optional<Entrant> ray_maker_;  ///< finds the hits that rays start from; not measured
  EmbreeLibrary drop_in_library_;
  Entrant drop_in_;
};

}  // namespace dacrt::bench
