// The bytes of one message: written by its sender, read with every length checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace dacrt::mpi {

/// A message is shorter than it says.
class CutMessage : public std::runtime_error {
 public:
  CutMessage() : std::runtime_error("a message was cut") {}
};

/// Memory that is not cleared: messages are large, and written once.
class Message {
 public:
  Message() = default;
  explicit Message(std::size_t bytes) { Extend(bytes); }

  std::byte* data() { return data_.get(); }
  const std::byte* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }

  /// `bytes` more, of undefined contents. What was there may move.
  std::byte* Extend(std::size_t bytes) {
    if (size_ + bytes > capacity_) {
      const std::size_t capacity = size_ + bytes + (size_ > 0 ? size_ : 0);
      auto data = std::make_unique_for_overwrite<std::byte[]>(capacity);
      if (size_ > 0) std::memcpy(data.get(), data_.get(), size_);
      data_ = std::move(data);
      capacity_ = capacity;
    }
    size_ += bytes;
    return data_.get() + size_ - bytes;
  }

  /// Drops all but the first `bytes`.
  void Shrink(std::size_t bytes) { size_ = bytes; }

  Message Copy() const {
    Message copy(size_);
    if (size_ > 0) std::memcpy(copy.data(), data(), size_);
    return copy;
  }

  template <class T>
  void Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(Extend(sizeof(T)), &value, sizeof(T));
  }
  void PutText(std::string_view text) {
    Put(static_cast<uint64_t>(text.size()));
    if (!text.empty()) std::memcpy(Extend(text.size()), text.data(), text.size());
  }

 private:
  std::unique_ptr<std::byte[]> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

/// Reads a message from its start. All throw CutMessage where there is less than asked for.
class Reader {
 public:
  explicit Reader(const Message& message) : next_(message.data()), left_(message.size()) {}

  const std::byte* Take(std::size_t bytes) {
    if (bytes > left_) throw CutMessage();
    const std::byte* const taken = next_;
    next_ += bytes;
    left_ -= bytes;
    return taken;
  }
  template <class T>
  T Take() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, Take(sizeof(T)), sizeof(T));
    return value;
  }
  std::string TakeText() {
    const auto length = Take<uint64_t>();
    return std::string(reinterpret_cast<const char*>(Take(length)), length);
  }

  std::size_t left() const { return left_; }

  /// Throws CutMessage if something is left: then the message is not what it says either.
  void ExpectEnd() const {
    if (left_ != 0) throw CutMessage();
  }

 private:
  const std::byte* next_;
  std::size_t left_;
};

}  // namespace dacrt::mpi
