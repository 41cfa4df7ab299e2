// The results of moving_bench: goals, tables, plots.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "goal.h"
#include "moving_results.h"

namespace dacrt::bench {

/// Every goal, whether there are cells for it or not.
std::vector<Goal> JudgeGoals(const MovingResults& results);

void PrintText(const MovingResults& results, std::ostream& out);

/// The same as a page, with the command that made it.
void PrintMarkdown(const MovingResults& results, std::ostream& out);

/// A panel for each change: the ratio, a line for each kind of rays and number of threads, against
/// the rays a frame.
std::string MovingPlot(const MovingResults& results, const std::string& scene);

/// Writes moving-SCENE.svg into the folder for each scene, and returns these names. Throws
/// OutputError (errors.h).
std::vector<std::string> WritePlots(const MovingResults& results,
                                    const std::filesystem::path& folder);

}  // namespace dacrt::bench
