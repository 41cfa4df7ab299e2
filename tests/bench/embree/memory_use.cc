#include "memory_use.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <utility>

#include "committed_scene.h"

namespace dacrt::bench {
namespace {

// The bytes that a library says it allocates and frees.
struct Announced {
  std::atomic<ssize_t> now = 0;
  std::atomic<ssize_t> peak = 0;

  static bool Add(void* announced, ssize_t bytes, bool) {
    auto& [now, peak] = *static_cast<Announced*>(announced);
    const ssize_t sum = now += bytes;
    for (ssize_t most = peak; most < sum && !peak.compare_exchange_weak(most, sum);) {
    }
    return true;
  }
};

// The figure of that name in a file of /proc.
std::size_t ReadBytes(const char* path, const std::string& name) {
  std::ifstream file(path);
  for (std::string word; file >> word;) {
    if (word != name) continue;
    std::size_t kilobytes;
    if (file >> kilobytes) return kilobytes * 1024;
  }
  throw std::runtime_error(std::string(path) + " does not say " + name);
}

// What the process holds. Pages of files, such as a library's code, are no memory of a scene, nor
// are those that the system may take.
struct Resident {
  std::size_t lazily_free = ReadBytes("/proc/self/smaps_rollup", "LazyFree:");
  std::size_t anonymous = ReadBytes("/proc/self/smaps_rollup", "Anonymous:") - lazily_free;
  std::size_t files = ReadBytes("/proc/self/smaps_rollup", "Rss:") - lazily_free - anonymous;
  std::size_t peak = ReadBytes("/proc/self/status", "VmHWM:");  // of all pages
};

std::size_t Difference(std::size_t after, std::size_t before) {
  return after - std::min(before, after);
}

}  // namespace

MemoryUse MeasureMemory(const std::string& path, const std::string& config,
                        const SceneContent& content, RayBuffer& rays) {
  const EmbreeLibrary library(path, config);
  Announced announced;
  library.api().rtcSetDeviceMemoryMonitorFunction(library.device().handle(), &Announced::Add,
                                                  &announced);
  const Resident before;
  std::optional<CommittedScene> committed(std::in_place, library, content, Build::kMedium);
  committed->Trace(Query::kClosest, kIncoherentStream, rays.rays());
  malloc_trim(0);  // what is free again is not held, whether malloc has returned it yet or not
  const Resident after;
  const auto kept_announced = static_cast<std::size_t>(announced.now);
  committed.reset();
  malloc_trim(0);
  const Resident left;
  return {.kept_announced = kept_announced,
          .peak_announced = static_cast<std::size_t>(announced.peak),
          .kept_resident = Difference(after.anonymous, before.anonymous),
          .peak_resident = Difference(after.peak - after.files, before.anonymous),
          .left_resident = Difference(left.anonymous, before.anonymous)};
}

}  // namespace dacrt::bench
