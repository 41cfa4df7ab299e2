// A world's top scene as triangles at one moment, for the generator of rays: what it aims at.
#pragma once

#include <vector>

#include "scenes.h"
#include "world.h"

namespace dacrt::tests {

/// Every facet as it is at the first time step, a triangle through the middle of every point,
/// instances where they stand at the first time step.
TestScene Outline(const std::vector<WorldScene>& scenes);

}  // namespace dacrt::tests
