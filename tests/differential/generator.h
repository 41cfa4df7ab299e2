// Random worlds.
#pragma once

#include <cstddef>
#include <cstdint>

#include "feature_set.h"
#include "world.h"

namespace dacrt::tests {

/// The world of a seed: scenes, changes, and batches that say how about `rays` rays in all are to
/// be traced, but not yet which (see Duel::MakeRays). The same for the same arguments everywhere.
World MakeWorld(uint64_t seed, const Features& features, std::size_t rays);

}  // namespace dacrt::tests
