#include "worlds.h"

#include <algorithm>

#include "generator.h"
#include "outline.h"
#include "random.h"
#include "rays.h"

namespace dacrt::tests {
namespace {

bool IsPart(std::size_t geometry, int rank, int ranks) {
  return geometry % static_cast<std::size_t>(ranks) == static_cast<std::size_t>(rank);
}

RayKind KindNamed(const std::string& name) {
  const std::vector<RayKind> kinds = AllRayKinds();
  return *std::find_if(kinds.begin(), kinds.end(),
                       [&](RayKind kind) { return name == Name(kind); });
}

}  // namespace

World StreamWorld(uint64_t seed, const char* features, std::size_t rays) {
  World world = MakeWorld(seed, ParseFeatures(features), rays);
  world.drop_in_config.clear();
  for (Stage& stage : world.stages) {
    for (Batch& batch : stage.batches) {
      const bool is_stream =
          batch.form.call != Form::Call::kRecord && batch.form.call != Form::Call::kPacket;
      if (!is_stream) batch.form = {Form::Call::kRecords};
    }
  }
  return world;
}

std::vector<WorldScene> PartOf(const std::vector<WorldScene>& scenes, int rank, int ranks) {
  std::vector<WorldScene> part = scenes;
  std::vector<WorldGeometry>& geometries = part.back().geometries;
  for (std::size_t i = 0; i < geometries.size(); ++i) {
    geometries[i].attached &= IsPart(i, rank, ranks);
  }
  return part;
}

std::vector<Change> PartOf(const std::vector<Change>& changes, std::size_t scenes, int rank,
                           int ranks) {
  std::vector<Change> part;
  for (const Change& change : changes) {
    Change& own = part.emplace_back(change);
    const bool is_elsewhere = change.scene + 1 == scenes && !IsPart(change.geometry, rank, ranks);
    const bool attaches =
        change.kind == Change::Kind::kAttach || change.kind == Change::Kind::kDetach;
    if (is_elsewhere && attaches) own.kind = Change::Kind::kEnable;
  }
  return part;
}

void MakeRays(const std::vector<WorldScene>& scenes, Batch& batch, uint64_t seed) {
  const TestScene outline = Outline(scenes);
  // Rays that begin at hits begin somewhere else here, which does as well.
  const RayGenerator generator(outline, [](std::span<RTCRayHit>) {});
  batch.rays = generator.Make(KindNamed(batch.ray_kind), batch.rays.size(), seed);
  Random random(SeedFor("rays", seed));
  uint32_t id = 0;
  for (RTCRayHit& record : batch.rays) {
    record.ray.id = id++;
    record.ray.time = random.Uniform();
    if (random.Chance(0.2f)) record.ray.mask = random.Bits();
  }
}

}  // namespace dacrt::tests
