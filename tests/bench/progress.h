// How far a benchmark is, on the standard error.
#pragma once

#include <cstddef>
#include <string>

namespace dacrt::bench {

/// On a terminal one line, which is overwritten and is gone at the end; else a line for each
/// finished step.
class Progress {
 public:
  explicit Progress(std::size_t steps);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// What the step at hand is doing. Shown on a terminal only.
  void Show(const std::string& what) const;

  /// The step at hand is done.
  void Finish(const std::string& what);

  /// `count` steps will not be done.
  void Skip(std::size_t count);

  /// A message that stays.
  void Say(const std::string& message) const;

 private:
  std::string Prefix(std::size_t step) const;

  std::size_t steps_;
  std::size_t done_ = 0;
  bool is_terminal_;
};

}  // namespace dacrt::bench
