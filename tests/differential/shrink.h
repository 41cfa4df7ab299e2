// From a failing world to a small one that still fails.
#pragma once

#include <functional>

#include "world.h"

namespace dacrt::tests {

/// Leaves out whatever can be left out so that `fails` still holds: rays, changes, geometries,
/// primitives, time steps, and all that is not the default. `world` must fail, and have all its
/// batches in the last stage. `fails` is called at most `most_trials` times.
World Shrink(World world, const std::function<bool(const World&)>& fails, int most_trials = 2000);

}  // namespace dacrt::tests
