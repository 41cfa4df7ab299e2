#include "frame.h"

#include <utility>

namespace dacrt::bench {
namespace {

constexpr FrameKind kFrameKinds[] = {
    {"point", "point light, reflection", Occlusion::kPointLight, Scatter::kMirror, 1, false},
    {"area", "area light, reflection", Occlusion::kPanelLight, Scatter::kMirror, 1, false},
    {"ambient", "ambient occlusion", Occlusion::kAmbient, Scatter::kDiffuse, 0, false},
    {"path", "path tracing", Occlusion::kPanelLight, Scatter::kDiffuse, 3, false},
    {"path-dof", "path tracing, depth of field", Occlusion::kPanelLight, Scatter::kDiffuse, 3,
     true},
};

std::string Name(const FrameKind& kind, int bounce) {
  if (bounce == 0) return "primary";
  if (kind.scatter == Scatter::kMirror) return "reflection";
  return "bounce " + std::to_string(bounce);
}

const char* Name(Occlusion occlusion) {
  return occlusion == Occlusion::kAmbient ? "ambient occlusion" : "shadow";
}

}  // namespace

std::span<const FrameKind> FrameKinds() { return kFrameKinds; }

void TraceFrame(const FrameKind& kind, const BenchScene& scene, const Raster& raster,
                const TracePass& trace) {
  const RayGeneration generation(scene);
  RayBuffer hits(raster.RayCount());
  RayBuffer next(raster.RayCount());
  generation.MakeCameraRays(raster, kind.thin_lens, hits);
  for (int bounce = 0;; ++bounce) {
    const std::string name = Name(kind, bounce);
    trace({name, Query::kClosest}, hits);
    generation.MakeOcclusionRays(kind.occlusion, bounce, hits, next);
    trace({name + ", " + Name(kind.occlusion), Query::kAny}, next);
    if (bounce == kind.bounces) return;
    generation.Continue(kind.scatter, bounce, hits, next);
    std::swap(hits, next);
  }
}

}  // namespace dacrt::bench
