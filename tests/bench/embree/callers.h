// Several threads that call a library at the same time.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace dacrt::bench {

/// Embree traces a stream on the thread that calls, so a program that wants more of them at work
/// cuts its batch into slices and calls from several threads.
///
/// The threads wait busily, because a small batch would be traced before a sleeping one is awake:
/// keep this no longer than it is used.
class Callers {
 public:
  /// `count` threads, of which the one that calls Run is the first.
  explicit Callers(int count);
  ~Callers();
  Callers(const Callers&) = delete;
  Callers& operator=(const Callers&) = delete;

  /// Calls `work`, which must not throw, once with each number below `count`: every thread takes
  /// the next number as soon as it is free. Returns when all is done.
  void Run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  void Help();
  void TakeWork();

  const std::function<void(std::size_t)>* work_ = nullptr;  ///< null: there will be no more
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_ = 0;
  std::atomic<unsigned> round_ = 0;  ///< a new one says that the members above are set
  std::atomic<std::size_t> busy_ = 0;
  std::vector<std::jthread> helpers_;
};

}  // namespace dacrt::bench
