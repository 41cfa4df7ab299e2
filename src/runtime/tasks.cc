#include "runtime/tasks.h"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cfenv>
#include <memory>
#include <new>
#include <stdexcept>
#include <string_view>

namespace dacrt {
namespace {

/// Sets the floating-point environment of a thread, and back.
class WithEnvironment {
 public:
  explicit WithEnvironment(const std::fenv_t& environment) {
    std::fegetenv(&own_);
    std::fesetenv(&environment);
  }
  ~WithEnvironment() { std::fesetenv(&own_); }
  WithEnvironment(const WithEnvironment&) = delete;
  WithEnvironment& operator=(const WithEnvironment&) = delete;

 private:
  std::fenv_t own_;
};

/// Throws std::bad_alloc where there is no room for what oneTBB takes when it starts: it never
/// comes back from finding that out while it looks at the machine.
void AskForRoomToStart() {
  constexpr std::size_t kBytes = 1 << 20;
  std::make_unique_for_overwrite<char[]>(kBytes);
}

/// Runs what may start threads. One that cannot be started is memory that has run out; oneTBB says
/// so in words.
template <class Body>
void WithThreads(Body&& body) {
  try {
    body();
  } catch (const std::runtime_error& error) {
    if (std::string_view(error.what()).starts_with("pthread_create")) throw std::bad_alloc();
    throw;
  }
}

}  // namespace

struct TaskPool::Arena {
  /// At once, as an arena that failed to come into being on its first use waits for that for ever.
  explicit Arena(std::size_t threads) : arena(static_cast<int>(threads)) { arena.initialize(); }
  tbb::task_arena arena;
};

TaskPool::TaskPool(std::size_t threads) : threads_(1) {
  // Without oneTBB, which never comes back from running out of memory while it starts.
  if (threads == 1) return;
  AskForRoomToStart();
  threads_ = static_cast<std::size_t>(tbb::info::default_concurrency());
  if (threads != 0) threads_ = std::min(threads, threads_);
  arena_ = std::make_unique<Arena>(threads_);
}

TaskPool::~TaskPool() = default;

void TaskPool::ForEach(std::size_t count, const std::function<void(std::size_t)>& body) {
  if (count == 1 || threads_ == 1) {
    // Without the arena, which would wait for its turn where many threads call.
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  std::fenv_t callers;
  std::fegetenv(&callers);
  const auto run = [&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          const WithEnvironment environment(callers);
          for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
        },
        tbb::simple_partitioner());
  };
  WithThreads([&] { arena_->arena.execute([&] { tbb::this_task_arena::isolate(run); }); });
}

void TaskPool::Enter(const std::function<void()>& body) {
  if (threads_ == 1) return body();
  std::fenv_t callers;
  std::fegetenv(&callers);
  WithThreads([&] {
    arena_->arena.execute([&] {
      const WithEnvironment environment(callers);  // another thread may do it
      body();
    });
  });
}

}  // namespace dacrt
