// The goals of the comparison with Embree, and what a run of embree_bench says of them.
#pragma once

#include <vector>

#include "embree_results.h"
#include "goal.h"

namespace dacrt::bench {

/// Every goal, whether there are cells for it or not.
std::vector<Goal> JudgeGoals(const EmbreeResults& results);

}  // namespace dacrt::bench
