// A benchmark's command line.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace dacrt::bench {

/// False if only help was asked for, which has then been printed. Throws UsageError.
bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv);

/// Of the entries of a table that have a member `name`.
template <class Entries>
std::vector<std::string> NamesOf(const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.name);
  return names;
}

/// What made the results, for whoever wants to repeat it: `program` with its arguments.
std::string CommandText(const std::string& program, int argc, const char* const* argv);

}  // namespace dacrt::bench
