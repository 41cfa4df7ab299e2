#include "tests/program.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <system_error>

namespace sample_test {
namespace {

namespace fs = std::filesystem;

std::string Quoted(const std::string& word) {
  std::string quoted = "'";
  for (char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

int ExitCode(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Outcome RunProgram(const fs::path& folder, const std::string& program,
                   const std::vector<std::string>& arguments, const std::string& limits) {
  const TemporaryFolder captured;
  const fs::path output = captured / "output";
  const fs::path errors = captured / "errors";
  std::ostringstream command;
  command << "(cd " << Quoted(folder.string()) << " && " << limits << " && exec "
          << Quoted(program);
  for (const std::string& argument : arguments) command << ' ' << Quoted(argument);
  command << ") >" << Quoted(output.string()) << " 2>" << Quoted(errors.string());
  const int status = std::system(command.str().c_str());
  return {ExitCode(status), ReadFile(output), ReadFile(errors)};
}

Outcome RunOnTerminal(const fs::path& folder, const std::string& program,
                      const std::vector<std::string>& arguments, const std::string& interrupt_at) {
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child == 0) {
    if (chdir(folder.c_str()) == 0) execv(program.c_str(), argv.data());
    _exit(127);
  }
  if (child < 0) throw std::system_error(errno, std::generic_category(), "forkpty");
  std::string output;
  bool interrupt = !interrupt_at.empty();
  char read_now[4096];
  // Ends with the child, by an error: the terminal has no other side any more.
  for (ssize_t size; (size = read(terminal, read_now, sizeof(read_now))) > 0;) {
    output.append(read_now, size);
    if (interrupt && output.find(interrupt_at) != std::string::npos) {
      constexpr char kControlC = 3;
      interrupt = write(terminal, &kControlC, 1) != 1;
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  close(terminal);
  return {ExitCode(status), output, ""};
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "sample_test.XXXXXX").string();
  if (!mkdtemp(name.data())) throw fs::filesystem_error("mkdtemp", name, {});
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<std::string> TemporaryFolder::Names() const {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(path_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void WriteFile(const fs::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

std::string ReadFile(const fs::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

}  // namespace sample_test
