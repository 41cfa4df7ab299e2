#include "ray_kind.h"

#include <algorithm>
#include <iterator>

#include "random.h"

namespace dacrt::bench {
namespace {

void MakeShadowRays(const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
  generation.MakeOcclusionRays(Occlusion::kPointLight, 0, hits, rays);
}

void MakeAmbientRays(const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
  generation.MakeOcclusionRays(Occlusion::kAmbient, 0, hits, rays);
}

void MakeDiffuseRays(const RayGeneration& generation, const RayBuffer& hits, RayBuffer& rays) {
  generation.Continue(Scatter::kDiffuse, 0, hits, rays);
}

constexpr RayKind kRayKinds[] = {
    {"primary", Query::kClosest, 1, nullptr},     {"shadow", Query::kAny, 1, MakeShadowRays},
    {"ambient", Query::kAny, 1, MakeAmbientRays}, {"diffuse", Query::kClosest, 1, MakeDiffuseRays},
    {"primary-4", Query::kClosest, 2, nullptr},   {"shadow-4", Query::kAny, 2, MakeShadowRays},
};

}  // namespace

std::span<const RayKind> RayKinds() { return kRayKinds; }

const RayKind* FindRayKind(const std::string& name) {
  const auto found = std::ranges::find(kRayKinds, name, &RayKind::name);
  return found == std::end(kRayKinds) ? nullptr : found;
}

RayBuffer RaySource::Make(const RayKind& kind, std::uint32_t rays_a_side, const Trace& trace) {
  const Raster picture = Raster::OfSamples(rays_a_side, kind.samples_a_side);
  if (!kind.make) return MakePrimary(picture);
  if (hits_picture_ != picture) {
    primary_hits_.reset();  // before the next is made: the two may not fit into memory together
    primary_hits_.emplace(MakePrimary(picture));
    trace(*primary_hits_);
    hits_picture_ = picture;
  }
  RayBuffer rays(picture.RayCount());
  kind.make(generation_, *primary_hits_, rays);
  GiveNeeds(rays);
  return rays;
}

RayBuffer RaySource::MakePrimary(const Raster& picture) const {
  RayBuffer rays(picture.RayCount());
  generation_.MakeCameraRays(picture, false, rays);
  GiveNeeds(rays);
  return rays;
}

void RaySource::GiveNeeds(RayBuffer& rays) const {
  if (!needs_.times && !needs_.masks) return;
  for (RayRecord& ray : rays.rays()) {
    tests::Random random(ray.id);
    if (needs_.times) ray.time = random.Uniform();
    if (needs_.masks) ray.mask = random.Chance(0.5f) ? 1 : UINT32_MAX;
  }
}

}  // namespace dacrt::bench
