// The frames of the paper: which rays a renderer sends, pass by pass.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "ray_generation.h"

namespace dacrt::bench {

/// One kind of frame: primary rays, and from their hits on occlusion rays and further bounces.
struct FrameKind {
  const char* name;
  const char* title;
  Occlusion occlusion;
  Scatter scatter;
  int bounces;
  bool thin_lens;  ///< depth of field; else a pinhole
};

std::span<const FrameKind> FrameKinds();

/// One batch of a frame.
struct Pass {
  std::string name;
  Query query;
};

/// Traces the rays of `pass` and leaves the hits in them.
using TracePass = std::function<void(const Pass& pass, RayBuffer& rays)>;

/// Makes the rays of every pass in turn and has them traced. A later pass has a ray for each hit of
/// the pass it follows from, less those that a renderer would not send: a shadow ray where the
/// surface faces away from the light.
///
/// Two batches are alive at a time.
void TraceFrame(const FrameKind& kind, const BenchScene& scene, const Raster& raster,
                const TracePass& trace);

}  // namespace dacrt::bench
