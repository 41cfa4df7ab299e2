// Reading a benchmark's command line.
#pragma once

#include <CLI/CLI.hpp>

namespace dacrt::bench {

/// False if only help was asked for, which has then been printed. Throws UsageError.
bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

}  // namespace dacrt::bench
