// What dacrt is to reach beside Embree: a figure, how it is judged, and what a run says of it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "table.h"

namespace dacrt::bench {

struct Goal {
  enum class Bound { kAtLeast, kAtMost };
  enum class Judged {
    kGeometricMean,  ///< of all cells
    kWorstMean,      ///< the worst of the geometric means of groups of cells
    kWorstCell,
  };

  std::string figure;
  Judged judged;
  Bound bound;
  double goal;
  std::size_t cells;               ///< that have this figure
  std::optional<double> measured;  ///< nothing if there are no cells
  std::string worst;               ///< cell, or group where their means are judged

  bool IsMet() const;
};

/// As "geometric mean".
const char* Name(Goal::Judged judged);

/// One cell's share in a figure.
struct GoalSample {
  double value;
  std::string cell;
  std::string group;  ///< where groups are judged
};

Goal Judge(const std::string& figure, Goal::Judged judged, Goal::Bound bound, double goal,
           const std::vector<GoalSample>& samples);

/// A row for each goal.
Table GoalsTable(const std::vector<Goal>& goals);

}  // namespace dacrt::bench
