// The results as plots.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results.h"

namespace dacrt::bench {

/// A panel for each kind of frame and a line for each scene: the time of one method over that of
/// the first against the number of rays, and the paper's figures.
std::string RatioPlot(const std::vector<FrameResult>& frames, std::size_t rival);

/// Time by scene and kind of frame, for the most rays.
std::string TimePlot(const std::vector<FrameResult>& frames);

/// The same bars, cut into the stages that the time goes to.
std::string StagePlot(const std::vector<FrameResult>& frames);

/// A row for each changed setting, a dot for each frame, and a bar at their geometric mean.
std::string AblationPlot(const std::vector<FrameResult>& frames);

/// Writes what there are results for into the folder: ratio-ALGORITHM.svg for each but the first,
/// time.svg, stages.svg, ablation.svg. Throws OutputError.
void WritePlots(const Results& results, const std::filesystem::path& folder);

}  // namespace dacrt::bench
