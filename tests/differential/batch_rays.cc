#include "batch_rays.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>

#include "callbacks.h"
#include "outline.h"
#include "random.h"
#include "rays.h"

namespace dacrt::tests {
namespace {

RayKind KindNamed(const std::string& name) {
  for (const RayKind kind : AllRayKinds()) {
    if (name == Name(kind)) return kind;
  }
  throw std::invalid_argument("there is no kind of rays " + name);
}

/// The time steps of the moving geometry that has most.
const WorldGeometry* MostMoving(const std::vector<WorldScene>& scenes) {
  const WorldGeometry* most = nullptr;
  for (const WorldScene& scene : scenes) {
    for (const WorldGeometry& geometry : scene.geometries) {
      if (geometry.StepCount() > (most ? most->StepCount() : 1)) most = &geometry;
    }
  }
  return most;
}

/// Times that are likely to find faults: of steps, and of the ends of ranges.
float SpecialTime(const WorldGeometry& geometry, Random& random) {
  const float ends[] = {0, 1, geometry.time_begin, geometry.time_end};
  if (random.Chance(0.5f)) return std::clamp(ends[random.Below(4)], 0.0f, 1.0f);
  const uint32_t segments = geometry.StepCount() - 1;
  const float share = static_cast<float>(random.Below(segments + 1)) / static_cast<float>(segments);
  return std::clamp(geometry.time_begin + share * (geometry.time_end - geometry.time_begin), 0.0f,
                    1.0f);
}

}  // namespace

void MakeRays(Batch& batch, uint64_t seed, const std::vector<WorldScene>& scenes,
              const PlayedWorld& probe) {
  const TestScene outline = Outline(scenes);
  const RayGenerator generator(outline, [&](std::span<RTCRayHit> rays) {
    CallContext call = MakeContext(FilterKind::kNone);
    const std::vector<RTCRayHit> traced = probe.Trace({}, rays, call);
    std::copy(traced.begin(), traced.end(), rays.begin());
  });
  batch.rays = generator.Make(KindNamed(batch.ray_kind), batch.rays.size(), seed);
  Random random(SeedFor("rays", seed));
  const WorldGeometry* const moving = MostMoving(scenes);
  const bool same_time = random.Chance(0.2f), some_masks = random.Chance(0.2f);
  const float time = moving ? SpecialTime(*moving, random) : 0;
  uint32_t id = 0;
  for (RTCRayHit& record : batch.rays) {
    record.ray.id = id++;
    if (some_masks) record.ray.mask = random.Bits();
    if (moving && same_time) record.ray.time = time;
    if (moving && random.Chance(0.1f)) record.ray.time = SpecialTime(*moving, random);
  }
}

}  // namespace dacrt::tests
