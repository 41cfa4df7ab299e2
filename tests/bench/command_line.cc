#include "command_line.h"

#include <string>

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

}  // namespace dacrt::bench
