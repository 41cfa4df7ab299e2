// Random worlds of the differential tests, played for several ranks and for one process.
#pragma once

#include <cstdint>
#include <vector>

#include "world.h"

namespace dacrt::tests {

/// Kinds of worlds that are played.
struct WorldShare {
  const char* name;
  const char* features;
};
inline constexpr WorldShare kWorldShares[] = {
    {"WithoutCallbacks", "-filters,-context_filters,-user"},
    {"Changing", "triangles,instances,changes,masks,layouts"},
    {"OfEverything", ""},
};

/// A world without what decides where a batch is traced: the configuration of the drop-in, and
/// forms that are no streams, which stay on their rank.
World StreamWorld(uint64_t seed, const char* features, std::size_t rays);

/// The part of a world that rank `rank` of `ranks` has: every so many-th geometry of the top scene.
/// The others are there, but not attached.
std::vector<WorldScene> PartOf(const std::vector<WorldScene>& scenes, int rank, int ranks);

/// `changes`, with which only that part is attached and detached. All ranks commit the same scenes.
std::vector<Change> PartOf(const std::vector<Change>& changes, std::size_t scenes, int rank,
                           int ranks);

/// Fills in the rays of `batch`, aimed at `scenes` as they are now.
void MakeRays(const std::vector<WorldScene>& scenes, Batch& batch, uint64_t seed);

}  // namespace dacrt::tests
