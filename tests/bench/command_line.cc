#include "command_line.h"

#include <CLI/CLI.hpp>

#include <set>
#include <thread>

#include "errors.h"

namespace dacrt::bench {

bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    app.exit(help);
    return false;
  } catch (const CLI::ParseError& error) {
    throw UsageError(std::string(error.what()) + " (see --help)");
  }
  return true;
}

void AddNamesOption(CLI::App& app, const std::string& option, std::vector<std::string>& names,
                    const std::vector<std::string>& legal, const std::string& text) {
  app.add_option(option, names, text)->check(CLI::IsMember(legal))->type_name("NAME");
}

std::vector<int> OneAndAllThreads() {
  const int all = static_cast<int>(std::thread::hardware_concurrency());
  return all > 1 ? std::vector{1, all} : std::vector{1};
}

void AddThreadsOption(CLI::App& app, std::vector<int>& threads) {
  const auto set = [&threads](const std::vector<int>& numbers) {
    const std::set<int> each(numbers.begin(), numbers.end());
    threads.assign(each.begin(), each.end());
  };
  app.add_option_function<std::vector<int>>("--threads", set,
                                            "Numbers of threads, by default one and all")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
}

std::string CommandText(const std::string& program, int argc, const char* const* argv) {
  std::string command = program;
  for (int i = 1; i < argc; ++i) command += std::string(" ") + argv[i];
  return command;
}

}  // namespace dacrt::bench
