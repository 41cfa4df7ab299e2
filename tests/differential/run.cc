#include "run.h"

#include "generator.h"
#include "random.h"

namespace dacrt::tests {
namespace {

/// What a world is counted as: what of the more difficult things it holds.
std::string Kind(const World& world) {
  bool moves = false, has_instances = false, has_callbacks = false;
  for (const WorldScene& scene : world.scenes) {
    for (const WorldGeometry& geometry : scene.geometries) {
      moves = moves || geometry.StepCount() > 1;
      has_instances = has_instances || geometry.shape == Shape::kInstance;
      has_callbacks = has_callbacks || geometry.shape == Shape::kUser ||
                      geometry.closest_filter != FilterKind::kNone ||
                      geometry.any_filter != FilterKind::kNone;
    }
  }
  std::string kind = moves ? "moving" : "still";
  if (has_instances) kind += ", instances";
  if (has_callbacks) kind += ", callbacks";
  return kind;
}

/// The world with nothing after a batch, and no other batch.
World OnlyWith(const World& world, std::size_t stage, const Batch& batch) {
  World part = world;
  part.stages.resize(stage + 1);
  for (Stage& other : part.stages) other.batches.clear();
  part.stages.back().batches.push_back(batch);
  return part;
}

/// `prepare(duel, batch)` fills in the rays, where they are missing.
template <typename Prepare>
std::optional<Failure> Run(Arena& arena, const World& world, Report& report, const ShowWorld& show,
                           const Prepare& prepare) {
  const std::string kind = Kind(world);
  Duel duel(arena, world);
  for (std::size_t i = 0; i < world.stages.size(); ++i) {
    duel.Commit(world.stages[i].changes);
    for (const Batch& given : world.stages[i].batches) {
      Batch batch = given;
      prepare(duel, batch);
      if (show) show(OnlyWith(world, i, batch));
      std::vector<Finding> findings = duel.Run(batch, report.At(kind, batch.ray_kind));
      if (!findings.empty()) {
        return Failure{OnlyWith(world, i, batch), std::move(findings.front())};
      }
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Failure> RunSeed(Arena& arena, uint64_t seed, const Features& features,
                               std::size_t rays, Report& report, const ShowWorld& show) {
  uint64_t batch_number = 0;
  const World world = MakeWorld(seed, features, rays);
  // So that a failure while the scenes are made is shown as well.
  if (show) show(OnlyWith(world, 0, Batch{}));
  return Run(arena, world, report, show, [&](const Duel& duel, Batch& batch) {
    duel.MakeRays(batch, SeedFor("batch", seed + (batch_number++ << 32)));
  });
}

std::optional<Failure> RunWorld(Arena& arena, const World& world, Report& report) {
  return Run(arena, world, report, {}, [](const Duel&, Batch&) {});
}

}  // namespace dacrt::tests
