// Scenes, and random worlds of the differential tests, for several ranks and for one process.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "embree_scene.h"

namespace dacrt::tests {

/// Of the scenes that all ranks can take: the large ones of the folder would only take time.
std::vector<std::string> SceneNames();

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

/// Plays worlds 1 to `last` on both devices, on `several` as rank `rank` of `ranks` ranks, each of
/// which has every so many-th geometry of the top scene. Expects the same bits, for rays of the
/// rank's own.
void ExpectSameWorlds(const EmbreeDevice& one, const EmbreeDevice& several, const WorldShare& share,
                      uint64_t last, int rank, int ranks);

}  // namespace dacrt::tests
