// What the filter functions of a scene have answered of late, which says when to ask them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace dacrt {

class FilterAnswers {
 public:
  /// Whether next to all hits that are shown are accepted.
  bool AcceptMost() const { return shown_ >= kFewest && kShownARejected * rejected_ <= shown_; }

  void Count(std::size_t shown, std::size_t accepted) {
    shown_ += static_cast<uint32_t>(shown);
    rejected_ += static_cast<uint32_t>(shown - accepted);
    // What was long ago is forgotten.
    if (shown_ < kMost) return;
    shown_ /= 2;
    rejected_ /= 2;
  }

 private:
  static constexpr uint32_t kFewest = 64, kMost = 1024, kShownARejected = 32;

  uint32_t shown_ = 0, rejected_ = 0;
};

}  // namespace dacrt
