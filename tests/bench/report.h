// The results as tables.
#pragma once

#include <iosfwd>

#include "results.h"

namespace dacrt::bench {

/// Of the frames that differ in the number of rays only, those with the most. In order.
std::vector<const FrameResult*> LargestFrames(const std::vector<FrameResult>& frames);

/// Geometric mean over `frames` of the time of one method over that of the first.
double MeanRatio(const std::vector<FrameResult>& frames, std::size_t method);

void PrintReport(const Results& results, std::ostream& out);

}  // namespace dacrt::bench
