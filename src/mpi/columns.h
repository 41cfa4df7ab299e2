// Values of many rays on the wire, one column after the other. A column whose values are all the
// same takes four bytes: the origins of a camera's rays, masks and times of most programs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "message.h"

namespace dacrt::mpi {

/// Writes columns of `count` values. What is_common says of them goes into the message's head.
class ColumnWriter {
 public:
  /// Writes behind what `message` holds.
  ColumnWriter(Message& message, std::size_t count) : message_(message), count_(count) {}

  /// A column of value(0), value(1) ...
  template <class Value>
  void Column(const Value& value) {
    const std::size_t start = message_.size();
    auto* const out = reinterpret_cast<uint32_t*>(message_.Extend(4 * count_));
    uint32_t differences = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      out[i] = value(i);
      differences |= out[i] ^ out[0];
    }
    if (differences == 0 && count_ > 1) {
      message_.Shrink(start + 4);
      is_common_ |= 1u << column_;
    }
    ++column_;
  }

  /// The same for a value that is known to be the same for all.
  void Common(uint32_t value) {
    Column([=](std::size_t) { return value; });
  }

  uint32_t is_common() const { return is_common_; }

 private:
  Message& message_;
  const std::size_t count_;
  uint32_t column_ = 0;
  uint32_t is_common_ = 0;
};

/// Reads them in the same order.
class ColumnReader {
 public:
  ColumnReader(Reader& reader, std::size_t count, uint32_t is_common)
      : reader_(reader), count_(count), is_common_(is_common) {}

  struct Column {
    const uint32_t* values;
    std::size_t step;  ///< 0 if all are the same
    uint32_t operator[](std::size_t i) const { return values[i * step]; }
  };

  Column Next() {
    const bool is_common = (is_common_ >> column_++) & 1;
    const std::size_t values = is_common ? 1 : count_;
    return {reinterpret_cast<const uint32_t*>(reader_.Take(4 * values)), is_common ? 0u : 1u};
  }

 private:
  Reader& reader_;
  const std::size_t count_;
  const uint32_t is_common_;
  uint32_t column_ = 0;
};

}  // namespace dacrt::mpi
