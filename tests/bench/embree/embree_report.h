// The results of embree_bench as tables.
#pragma once

#include <iosfwd>

#include "embree_results.h"

namespace dacrt::bench {

void PrintText(const EmbreeResults& results, std::ostream& out);

/// The same as a page, with the command that made it.
void PrintMarkdown(const EmbreeResults& results, std::ostream& out);

}  // namespace dacrt::bench
