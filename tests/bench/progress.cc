#include "progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace dacrt::bench {
namespace {

constexpr char kClearLine[] = "\r\033[K";

// A longer line would wrap, and could not be overwritten.
int TerminalWidth() {
  constexpr int kUsualWidth = 80;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col
                                                                         : kUsualWidth;
}

}  // namespace

Progress::Progress(std::size_t steps) : steps_(steps), is_terminal_(isatty(STDERR_FILENO)) {}

Progress::~Progress() {
  if (is_terminal_) std::fputs(kClearLine, stderr);
}

void Progress::Show(const std::string& what) const {
  if (!is_terminal_) return;
  const std::string line = Prefix(done_ + 1) + what;
  std::fprintf(stderr, "%s%.*s", kClearLine, TerminalWidth() - 1, line.c_str());
}

void Progress::Finish(const std::string& what) {
  ++done_;
  if (!is_terminal_) std::fprintf(stderr, "%s%s\n", Prefix(done_).c_str(), what.c_str());
}

void Progress::Skip(std::size_t count) { done_ += count; }

void Progress::Say(const std::string& message) const {
  std::fprintf(stderr, "%s%s\n", is_terminal_ ? kClearLine : "", message.c_str());
}

std::string Progress::Prefix(std::size_t step) const {
  return '[' + std::to_string(step) + '/' + std::to_string(steps_) + "] ";
}

}  // namespace dacrt::bench
