#include "worlds.h"

#include <algorithm>

#include "bits.h"
#include "contest.h"
#include "generator.h"
#include "outline.h"
#include "player.h"
#include "random.h"
#include "rays.h"
#include "world.h"

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

/// A world without what decides where a batch is traced: the configuration of the drop-in, and
/// forms that are no streams, which stay on their rank.
World StreamWorld(uint64_t seed, const char* features, std::size_t rays) {
  World world = MakeWorld(seed, ParseFeatures(features), rays);
  world.drop_in_config.clear();
  for (Stage& stage : world.stages) {
    for (Batch& batch : stage.batches) {
      if (!IsStream(batch.form)) batch.form = {Form::Call::kRecords};
    }
  }
  return world;
}

/// The part of a world that a rank has. The other geometries are there, but not attached.
std::vector<WorldScene> PartOf(const std::vector<WorldScene>& scenes, int rank, int ranks) {
  std::vector<WorldScene> part = scenes;
  std::vector<WorldGeometry>& geometries = part.back().geometries;
  for (std::size_t i = 0; i < geometries.size(); ++i) {
    geometries[i].attached &= IsPart(i, rank, ranks);
  }
  return part;
}

/// `changes`, with which only that part is attached and detached. All ranks commit the same scenes.
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

/// Fills in the rays of `batch`, aimed at `scenes` as they are now.
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

}  // namespace

std::vector<std::string> SceneNames() {
  std::vector<std::string> names;
  for (const SceneSource& source : AllScenes()) {
    if (source.name != "terrain_white_mountains" && source.name != "country_kitchen") {
      names.push_back(source.name);
    }
  }
  return names;
}

void ExpectSameWorlds(const EmbreeDevice& one, const EmbreeDevice& several, const WorldShare& share,
                      uint64_t last, int rank, int ranks) {
  for (uint64_t seed = 1; seed <= last; ++seed) {
    SCOPED_TRACE(seed);
    const World world = StreamWorld(seed, share.features, 3000);
    PlayedWorld one_world(one, world.scenes);
    PlayedWorld several_world(several, PartOf(world.scenes, rank, ranks));
    std::vector<WorldScene> scenes = world.scenes;
    for (const Stage& stage : world.stages) {
      one_world.Commit(stage.changes);
      several_world.Commit(PartOf(stage.changes, scenes.size(), rank, ranks));
      for (const Change& change : stage.changes) Apply(change, scenes);
      for (Batch batch : stage.batches) {
        MakeRays(scenes, batch, seed * 100 + static_cast<uint64_t>(rank));
        CallContext one_call = MakeContext(batch.context_filter);
        CallContext several_call = MakeContext(batch.context_filter);
        ExpectSame(batch.rays, one_world.Trace(batch, batch.rays, one_call),
                   several_world.Trace(batch, batch.rays, several_call));
      }
    }
  }
  several.CheckErrors();
}

}  // namespace dacrt::tests
