#include "ambient_occlusion/program.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "ambient_occlusion/error.h"

namespace ao {
namespace {

int Fail(const char* name, ExitCode code, std::string message) {
  // One line, whatever a library has put into its text.
  for (char& c : message) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "%s: %s\n", name, message.c_str());
  return int(code);
}

std::string NamesOfOptions(const CLI::App& app) {
  std::string names;
  for (const CLI::Option* option : app.get_options()) names += " " + option->get_name();
  return names;
}

}  // namespace

bool ParseCommandLine(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::Success& help) {
    app.exit(help);
    return false;
  } catch (const CLI::ExtrasError& error) {
    throw Error(ExitCode::kUsage, std::string(error.what()) + "; there are" + NamesOfOptions(app));
  } catch (const CLI::ParseError& error) {
    throw Error(ExitCode::kUsage, std::string(error.what()) + " (see --help)");
  }
}

int RunProgram(const char* name, const std::function<void()>& run) {
  try {
    run();
    return int(ExitCode::kSuccess);
  } catch (const Error& error) {
    return Fail(name, error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return Fail(name, ExitCode::kMemory, "out of memory");
  } catch (const std::exception& error) {
    return Fail(name, ExitCode::kOther, error.what());
  }
}

}  // namespace ao
