// The instruction sets that a library can be limited to.
#pragma once

#include <string>
#include <vector>

namespace dacrt::bench {

/// Of those that the benchmark has rows for, the ones that this machine has: the best first.
std::vector<std::string> IsasHere();

/// The instruction sets that Embree may be tried on where it is limited to `isa`: its AVX2 is
/// often faster than its AVX-512, and never hangs where that does.
std::vector<std::string> IsasWithin(const std::string& isa);

}  // namespace dacrt::bench
