// Which cells of the matrix a setting measures.
#pragma once

#include <string>
#include <vector>

#include "moving_results.h"

namespace dacrt::bench {

/// A part of the matrix: every combination of these.
struct MovingBlock {
  std::vector<std::string> scenes;
  std::vector<std::string> changes;
  std::vector<std::string> kinds;
  std::vector<std::string> sizes;
  std::vector<int> threads;
};

/// A few minutes, with cells for every goal. Scenes that are not in the folder are left out.
std::vector<MovingBlock> ShortMovingBlocks(const std::string& folder,
                                           const std::vector<int>& threads);

/// Everything: an hour or so.
std::vector<MovingBlock> FullMovingBlocks(const std::string& folder,
                                          const std::vector<int>& threads);

/// Every cell of the blocks once; those that are measured together follow each other.
std::vector<MovingCell> CellsOf(const std::vector<MovingBlock>& blocks);

/// Whether the cells have the same scene, change and threads.
bool AreMeasuredTogether(const MovingCell& a, const MovingCell& b);

/// primary and diffuse.
const std::vector<std::string>& MovingRayKinds();

}  // namespace dacrt::bench
