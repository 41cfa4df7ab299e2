// The bytes that a fuzzer makes, read as numbers. Behind their end there are zeros.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>

namespace dacrt::fuzz {

class Input {
 public:
  Input(const uint8_t* bytes, std::size_t count) : next_(bytes), left_(count) {}

  bool IsEmpty() const { return left_ == 0; }
  const uint8_t* rest() const { return next_; }
  std::size_t left() const { return left_; }

  template <class T>
  T Take() {
    T value{};
    const std::size_t count = std::min(sizeof(T), left_);
    if (count > 0) std::memcpy(&value, next_, count);
    next_ += count;
    left_ -= count;
    return value;
  }

  /// A number below `end`.
  unsigned int Below(unsigned int end) { return Take<uint8_t>() % end; }

  template <class T, std::size_t kCount>
  const T& OneOf(const T (&values)[kCount]) {
    return values[Below(kCount)];
  }

 private:
  const uint8_t* next_;
  std::size_t left_;
};

}  // namespace dacrt::fuzz
