// Runs worlds: generated ones of seeds, and given ones of regressions.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "duel.h"
#include "feature_set.h"
#include "report.h"

namespace dacrt::tests {

/// A world with a difference that is not explained: all of it up to the batch that shows it, with
/// that batch's rays, and no other batch.
struct Failure {
  World world;
  Finding finding;
};

/// Is shown each batch that is about to be run, as the only one of a world that has its rays.
using ShowWorld = std::function<void(const World&)>;

/// Runs the world of a seed. Stops at the first failure. What is counted goes to `report`.
std::optional<Failure> RunSeed(Arena& arena, uint64_t seed, const Features& features,
                               std::size_t rays, Report& report, const ShowWorld& show = {});

/// Runs a world whose batches have their rays, likewise.
std::optional<Failure> RunWorld(Arena& arena, const World& world, Report& report);

}  // namespace dacrt::tests
