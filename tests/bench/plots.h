// The results as plots.
#pragma once

#include <filesystem>

#include "results.h"

namespace dacrt::bench {

/// Writes into the folder, for what `results` has:
///   ratio-ALGORITHM.svg  time over that of the first algorithm against the number of rays
///   time.svg             by scene and kind of frame, for the most rays
///   stages.svg           where that time goes
///   ablation.svg         what each changed setting costs
/// Throws OutputError.
void WritePlots(const Results& results, const std::filesystem::path& folder);

}  // namespace dacrt::bench
