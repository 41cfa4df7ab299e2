// Worlds as text, in which failures are printed and regressions are kept: names and values,
// separated by white space; what follows a # on a line is a remark.
#pragma once

#include <iosfwd>
#include <string>

#include "world.h"

namespace dacrt::tests {

void Write(std::ostream& out, const World& world);

/// Throws std::runtime_error that says what was expected and what was found.
World ReadWorld(std::istream& in);

}  // namespace dacrt::tests
