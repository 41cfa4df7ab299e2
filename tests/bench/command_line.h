// A benchmark's command line.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace dacrt::bench {

/// False if only help was asked for, which has then been printed. Throws UsageError.
bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

/// What made the results, for whoever wants to repeat it: `program` with its arguments.
std::string CommandText(const std::string& program, int argc, const char* const* argv);

}  // namespace dacrt::bench
