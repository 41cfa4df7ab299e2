// The version of dacrt, by semantic versioning (https://semver.org): what a change of each number
// means is said in CHANGELOG.md. The build reads it from here.
#pragma once

#include <string_view>

#include "dacrt/export.h"

#define DACRT_VERSION_MAJOR 0
#define DACRT_VERSION_MINOR 1
#define DACRT_VERSION_PATCH 0

namespace dacrt {

/// The version of the library that the program runs with, e.g. "0.1.0", which may be a later one
/// than that of the headers that it was compiled with.
DACRT_API std::string_view Version();

}  // namespace dacrt
