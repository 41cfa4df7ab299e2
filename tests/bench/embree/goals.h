// What dacrt is to reach beside Embree, and what a run of embree_bench says of it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "embree_results.h"

namespace dacrt::bench {

struct Goal {
  enum class Bound { kAtLeast, kAtMost };
  enum class Judged { kGeometricMean, kWorstCell };

  std::string figure;
  Judged judged;
  Bound bound;
  double goal;
  std::size_t cells;               ///< that have this figure
  std::optional<double> measured;  ///< nothing if there are no cells
  std::string worst_cell;

  bool IsMet() const;
};

/// Every goal, whether there are cells for it or not.
std::vector<Goal> JudgeGoals(const EmbreeResults& results);

}  // namespace dacrt::bench
