#include "ambient_occlusion/progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace ao {
namespace {

constexpr char kClearLine[] = "\r\033[K";

}  // namespace

Progress::Progress(const std::string& step) : step_(step), visible_(isatty(STDERR_FILENO)) {
  if (visible_) std::fprintf(stderr, "%s%-16s", kClearLine, step_.c_str());
}

Progress::~Progress() {
  if (visible_) std::fputs(kClearLine, stderr);
}

void Progress::Update(double done) {
  constexpr double kInterval = 0.1;  // seconds
  if (!visible_ || since_drawn_.Seconds() < kInterval) return;
  since_drawn_ = Stopwatch();
  constexpr int kWidth = 40;
  const int filled = int(done * kWidth);
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  const double left = since_start_.Seconds() * (1 - done) / done;
  std::fprintf(stderr, "%s%-16s [%s] %3.0f %%, %.0f s left", kClearLine, step_.c_str(), bar.c_str(),
               100 * done, std::ceil(left));
}

}  // namespace ao
