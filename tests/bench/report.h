// The results as tables.
#pragma once

#include <iosfwd>

#include "results.h"

namespace dacrt::bench {

void PrintReport(const Results& results, std::ostream& out);

}  // namespace dacrt::bench
