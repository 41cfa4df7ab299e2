#pragma once

#include <string>

namespace dacrt::bench {

/// The name of the processor that this runs on, or "unknown".
std::string ProcessorName();

}  // namespace dacrt::bench
