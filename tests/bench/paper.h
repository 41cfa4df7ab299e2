// The figures of the paper, to stand beside ours.
#pragma once

#include <optional>
#include <string_view>

#include "measure.h"

namespace dacrt::bench {

/// Time of `rival` over time of nabata2013 in the paper, at 4096 x 4096 rays a pass, for the frame
/// that `frame` corresponds to; none where the first of its methods is another one. The paper's
/// largest scene, San Miguel, stands beside every scene of a million triangles and more; its figure
/// for Mora's method names no scene.
std::optional<double> PaperRatio(const FrameResult& frame, std::string_view rival);

}  // namespace dacrt::bench
