// A line on the terminal that says what is done and how long it will take.
#pragma once

#include <string>

#include "ambient_occlusion/stopwatch.h"

namespace ao {

// Shown from construction to destruction, on the standard error and only if that is a terminal.
class Progress {
 public:
  explicit Progress(const std::string& step);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Draws a bar, and the time left if the rest goes as fast as the part done, from 0 to 1.
  void Update(double done);

 private:
  std::string step_;
  bool visible_;
  Stopwatch since_start_;
  Stopwatch since_drawn_;
};

}  // namespace ao
