// The results of embree_bench as plots.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "embree_results.h"

namespace dacrt::bench {

/// A panel for each kind of rays: both ratios, a line for each number of threads, against the
/// number of rays a call. Of triangles, on the best instruction set.
std::string EmbreePlot(const EmbreeResults& results, const std::string& scene);

/// Writes embree-SCENE.svg into the folder for each scene, and returns these names. Throws
/// OutputError (errors.h).
std::vector<std::string> WritePlots(const EmbreeResults& results,
                                    const std::filesystem::path& folder);

}  // namespace dacrt::bench
