#include "ray_kind.h"

#include <algorithm>
#include <iterator>

namespace dacrt::bench {
namespace {

constexpr RayKind kRayKinds[] = {
    {"primary", Query::kClosest, nullptr},
    {"shadow", Query::kAny,
     [](const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
       generation.MakeOcclusionRays(Occlusion::kPointLight, 0, hits, rays);
     }},
    {"ambient", Query::kAny,
     [](const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
       generation.MakeOcclusionRays(Occlusion::kAmbient, 0, hits, rays);
     }},
    {"diffuse", Query::kClosest,
     [](const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
       generation.Continue(Scatter::kDiffuse, 0, hits, rays);
     }},
};

}  // namespace

std::span<const RayKind> RayKinds() { return kRayKinds; }

const RayKind* FindRayKind(const std::string& name) {
  const auto found = std::ranges::find(kRayKinds, name, &RayKind::name);
  return found == std::end(kRayKinds) ? nullptr : found;
}

RayBuffer RaySource::Make(const RayKind& kind, const Raster& picture, const Trace& trace) {
  RayBuffer rays(picture.RayCount());
  if (!kind.make) {
    generation_.MakeCameraRays(picture, false, rays);
    return rays;
  }
  if (!primary_hits_ || primary_hits_->rays().size() != picture.RayCount()) {
    primary_hits_.reset();  // before the next is made: the two may not fit into memory together
    primary_hits_.emplace(picture.RayCount());
    generation_.MakeCameraRays(picture, false, *primary_hits_);
    trace(*primary_hits_);
  }
  kind.make(generation_, *primary_hits_, rays);
  return rays;
}

}  // namespace dacrt::bench
