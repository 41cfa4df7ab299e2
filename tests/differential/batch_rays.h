// The rays of a batch.
#pragma once

#include <cstdint>
#include <vector>

#include "player.h"
#include "world.h"

namespace dacrt::tests {

/// Fills in the rays of a batch, aimed at what `scenes` are now. What has to be known of hits for
/// that is asked of `probe`, which holds the same scenes.
void MakeRays(Batch& batch, uint64_t seed, const std::vector<WorldScene>& scenes,
              const PlayedWorld& probe);

}  // namespace dacrt::tests
