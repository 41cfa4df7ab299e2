// Threads. The only place that knows oneTBB.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace dacrt {

/// The threads of a device, shared by all calls. Threads: any number may use a pool at once.
class TaskPool {
 public:
  /// At most `threads` at once, those of the callers included, and not more than the machine has,
  /// which is also what 0 means.
  explicit TaskPool(std::size_t threads);
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  std::size_t threads() const { return threads_; }

  /// Calls body(0) to body(count - 1), on several threads, and returns when all are done. One of
  /// them throws what a body throws. Meanwhile the caller works on nothing else, so it may hold
  /// what other bodies wait for.
  ///
  /// Bodies run with the caller's floating-point environment, so that whether it flushes small
  /// numbers to zero changes no bit from thread to thread.
  void ForEach(std::size_t count, const std::function<void(std::size_t)>& body);

  /// Calls `body` once, as one of the threads, and returns when it is done. ForEach in it does not
  /// wait for a free thread: the one that it has will do.
  void Enter(const std::function<void()>& body);

 private:
  struct Arena;
  std::size_t threads_;
  std::unique_ptr<Arena> arena_;  ///< null for one thread
};

}  // namespace dacrt
