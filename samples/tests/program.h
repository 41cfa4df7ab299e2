// Running a program and looking at what it leaves behind.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sample_test {

struct Outcome {
  int exit_code;  // 128 and the signal's number, as in a shell, if it was killed
  std::string output;
  std::string errors;
};

// Runs in the folder given. `limits` are shell commands to run before, such as ulimit.
Outcome RunProgram(const std::filesystem::path& folder, const std::string& program,
                   const std::vector<std::string>& arguments, const std::string& limits = ":");

// Runs on a terminal of its own, whose Ctrl-C is pressed as soon as the program has written
// `interrupt_at`, unless that is empty. What it writes there is `output`, errors too.
Outcome RunOnTerminal(const std::filesystem::path& folder, const std::string& program,
                      const std::vector<std::string>& arguments,
                      const std::string& interrupt_at = "");

// A fresh folder, gone at the end with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  // The names in it, in order.
  std::vector<std::string> Names() const;

 private:
  std::filesystem::path path_;
};

void WriteFile(const std::filesystem::path& path, const std::string& content);
std::string ReadFile(const std::filesystem::path& path);

}  // namespace sample_test
