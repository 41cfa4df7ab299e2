// What the programs have around their work: a command line, and one line where they fail.
#pragma once

#include <functional>

// Whoever adds options includes CLI11, which takes seconds to compile.
namespace CLI {
class App;
}

namespace ao {

// Prints the help and returns false when that is what was asked for. Throws Error with kUsage.
bool ParseCommandLine(CLI::App& app, int argc, char** argv);

// The exit code of `run`. What it throws is one line on the standard error, after the program's name.
int RunProgram(const char* name, const std::function<void()>& run);

}  // namespace ao
