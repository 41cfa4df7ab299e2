// A library that stands in front of one with Embree's interface (LD_PRELOAD): passes the calls on,
// and counts those that trace rays, look for points or commit scenes, and the time that they take.
//
// Compiled against Embree's headers, so that a signature that drifts does not build.
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "call_counts.h"

namespace {

using namespace dacrt::compare;
using Clock = std::chrono::steady_clock;

uint64_t Nanoseconds(Clock::duration duration) {
  return static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(duration).count());
}

uint32_t MeasureClock() {
  Clock::duration least = std::chrono::seconds(1);
  for (int i = 0; i < 100; ++i) {
    const auto start = Clock::now();
    least = std::min(least, Clock::now() - start);
  }
  return static_cast<uint32_t>(Nanoseconds(least));
}

/// Null where nobody counts: the calls are passed on all the same.
CountFile* OpenCounts() {
  const char* const path = std::getenv(kCountsVariable);
  if (!path) return nullptr;
  const int file = open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  void* const memory =
      mmap(nullptr, sizeof(CountFile), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (memory == MAP_FAILED) return nullptr;
  const auto counts = static_cast<CountFile*>(memory);
  counts->clock_nanoseconds = MeasureClock();
  return counts;
}

CountFile* AllCounts() {
  static CountFile* const counts = OpenCounts();
  return counts;
}

struct Thread {
  Thread() {
    if (CountFile* const all = AllCounts()) {
      const std::size_t number = all->threads++;
      is_shared = number + 1 >= CountFile::kThreads;
      counts = &all->of[std::min(number, CountFile::kThreads - 1)];
    }
  }

  ThreadCounts* counts = nullptr;
  bool is_shared = false;
  int depth = 0;  ///< calls that the thread is in
};

Thread& ThisThread() {
  thread_local Thread thread;
  return thread;
}

/// Counts a call as long as it lives.
class Counted {
 public:
  Counted(Kind kind, Form form, uint64_t rays) : thread_(ThisThread()) {
    ++thread_.depth;
    if (!thread_.counts) return;
    counts_ = &thread_.counts->of[static_cast<std::size_t>(kind)][static_cast<std::size_t>(form)];
    Add(counts_->calls, 1);
    Add(counts_->rays, rays);
    start_ = Clock::now();
  }

  ~Counted() {
    --thread_.depth;
    if (!counts_) return;
    if (thread_.depth > 0) {
      Add(counts_->inner_calls, 1);
    } else {
      Add(counts_->nanoseconds, Nanoseconds(Clock::now() - start_));
    }
  }

  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

 private:
  void Add(std::atomic<uint64_t>& sum, uint64_t value) const {
    if (thread_.is_shared) {
      sum.fetch_add(value, std::memory_order_relaxed);
    } else {  // nobody else writes
      sum.store(sum.load(std::memory_order_relaxed) + value, std::memory_order_relaxed);
    }
  }

  Thread& thread_;
  Counts* counts_ = nullptr;
  Clock::time_point start_;
};

/// The function of the library behind this one.
void* FindNext(const char* name) {
  if (void* const next = dlsym(RTLD_NEXT, name)) return next;
  // Loaded by the program itself, out of sight of the other libraries.
  if (void* const library = dlopen("libembree3.so.3", RTLD_LAZY | RTLD_NOLOAD)) {
    if (void* const next = dlsym(library, name)) return next;
  }
  std::fprintf(stderr, "dacrt-compare: there is no %s behind the counting library\n", name);
  std::abort();
}

void NoteLibrary(void* function) {
  CountFile* const all = AllCounts();
  Dl_info info{};
  if (!all || all->devices++ > 0 || !dladdr(function, &info) || !info.dli_fname) return;
  std::strncpy(all->library, info.dli_fname, sizeof(all->library) - 1);
}

uint64_t CountValid(const int* valid, int width) {
  return static_cast<uint64_t>(std::count(valid, valid + width, -1));
}

// The function behind this one, as the headers declare it.
#define NEXT(name) static const auto next = reinterpret_cast<decltype(&name)>(FindNext(#name))

// A function that passes its call on, and counts it.
#define COUNTED(result, name, parameters, arguments, kind, form, rays) \
  RTC_API result name parameters {                                     \
    NEXT(name);                                                        \
    const Counted counted(kind, form, rays);                           \
    return next arguments;                                             \
  }

// The forms in which rays come: Rays is the structure, 1 to 16 its lanes.
#define SINGLE(name, kind, Rays)                                                   \
  COUNTED(void, name, (RTCScene scene, RTCIntersectContext * context, Rays * ray), \
          (scene, context, ray), kind, Form::kSingle, 1)
#define PACKET(name, kind, Rays, lanes)                                                        \
  COUNTED(void, name##lanes,                                                                   \
          (const int* valid, RTCScene scene, RTCIntersectContext* context, Rays##lanes* rays), \
          (valid, scene, context, rays), kind, Form::kPacket, CountValid(valid, lanes))
#define RECORDS(name, kind, Rays)                                                                  \
  COUNTED(                                                                                         \
      void, name,                                                                                  \
      (RTCScene scene, RTCIntersectContext * context, Rays * rays, unsigned int M, size_t stride), \
      (scene, context, rays, M, stride), kind, FormOfStream(M), M)
#define ARRAY(name, kind, Rays)                                                           \
  COUNTED(void, name,                                                                     \
          (RTCScene scene, RTCIntersectContext * context, Rays rays, unsigned int count), \
          (scene, context, rays, count), kind, FormOfStream(count), count)
#define INTERLEAVED(name, kind, Rays)                                                  \
  COUNTED(void, name,                                                                  \
          (RTCScene scene, RTCIntersectContext * context, Rays * rays, unsigned int N, \
           unsigned int M, size_t stride),                                             \
          (scene, context, rays, N, M, stride), kind, FormOfStream(uint64_t{N} * M),   \
          uint64_t{N} * M)
#define POINTS(lanes)                                                                   \
  COUNTED(bool, rtcPointQuery##lanes,                                                   \
          (const int* valid, RTCScene scene, RTCPointQuery##lanes* query,               \
           RTCPointQueryContext* context, RTCPointQueryFunction function, void** data), \
          (valid, scene, query, context, function, data), Kind::kPoint, Form::kPacket,  \
          CountValid(valid, lanes))

// clang-format off: a line a function.
#define EVERY_FORM(name, kind, Rays)     \
  SINGLE(name##1, kind, Rays)            \
  PACKET(name, kind, Rays, 4)            \
  PACKET(name, kind, Rays, 8)            \
  PACKET(name, kind, Rays, 16)           \
  RECORDS(name##1M, kind, Rays)          \
  ARRAY(name##1Mp, kind, Rays**)         \
  ARRAY(name##Np, kind, const Rays##Np*) \
  INTERLEAVED(name##NM, kind, Rays##N)
// clang-format on

}  // namespace

extern "C" {

RTC_API RTCDevice rtcNewDevice(const char* config) {
  NEXT(rtcNewDevice);
  NoteLibrary(reinterpret_cast<void*>(next));
  return next(config);
}

RTC_API RTCGeometry rtcNewGeometry(RTCDevice device, RTCGeometryType type) {
  NEXT(rtcNewGeometry);
  const RTCGeometry geometry = next(device, type);
  if (!geometry && AllCounts()) ++AllCounts()->refused_geometries;
  return geometry;
}

COUNTED(void, rtcCommitScene, (RTCScene scene), (scene), Kind::kCommit, Form::kSingle, 0)
COUNTED(void, rtcJoinCommitScene, (RTCScene scene), (scene), Kind::kCommit, Form::kSingle, 0)

EVERY_FORM(rtcIntersect, Kind::kClosest, RTCRayHit)
EVERY_FORM(rtcOccluded, Kind::kAny, RTCRay)

COUNTED(bool, rtcPointQuery,
        (RTCScene scene, RTCPointQuery* query, RTCPointQueryContext* context,
         RTCPointQueryFunction function, void* data),
        (scene, query, context, function, data), Kind::kPoint, Form::kSingle, 1)
POINTS(4)
POINTS(8)
POINTS(16)

}  // extern "C"
