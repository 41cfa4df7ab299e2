// A benchmark's command line.
#pragma once

#include <string>
#include <vector>

// Whoever adds options includes CLI11, which takes seconds to compile.
namespace CLI {
class App;
}

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

/// Adds an option for a list of names out of the legal ones.
void AddNamesOption(CLI::App& app, const std::string& option, std::vector<std::string>& names,
                    const std::vector<std::string>& legal, const std::string& text);

/// One and as many as the machine has.
std::vector<int> OneAndAllThreads();

/// Adds --threads: numbers of them. Each once, the least first, when the line has been parsed.
void AddThreadsOption(CLI::App& app, std::vector<int>& threads);

/// What made the results, for whoever wants to repeat it: `program` with its arguments.
std::string CommandText(const std::string& program, int argc, const char* const* argv);

}  // namespace dacrt::bench
