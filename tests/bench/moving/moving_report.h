// The results of moving_bench: goals and tables.
#pragma once

#include <iosfwd>
#include <vector>

#include "goal.h"
#include "moving_results.h"

namespace dacrt::bench {

/// Every goal, whether there are cells for it or not.
std::vector<Goal> JudgeGoals(const MovingResults& results);

void PrintText(const MovingResults& results, std::ostream& out);

/// The same as a page, with the command that made it.
void PrintMarkdown(const MovingResults& results, std::ostream& out);

}  // namespace dacrt::bench
