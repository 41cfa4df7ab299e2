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

#define NEXT(name) static const auto next = reinterpret_cast<decltype(&name)>(FindNext(#name))

uint64_t CountValid(const int* valid, int width) {
  return static_cast<uint64_t>(std::count(valid, valid + width, -1));
}

}  // namespace

// As the headers declare them.
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

RTC_API void rtcCommitScene(RTCScene scene) {
  NEXT(rtcCommitScene);
  const Counted counted(Kind::kCommit, Form::kSingle, 0);
  next(scene);
}

RTC_API void rtcJoinCommitScene(RTCScene scene) {
  NEXT(rtcJoinCommitScene);
  const Counted counted(Kind::kCommit, Form::kSingle, 0);
  next(scene);
}

RTC_API void rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* rayhit) {
  NEXT(rtcIntersect1);
  const Counted counted(Kind::kClosest, Form::kSingle, 1);
  next(scene, context, rayhit);
}

RTC_API void rtcIntersect4(const int* valid, RTCScene scene, RTCIntersectContext* context,
                           RTCRayHit4* rayhit) {
  NEXT(rtcIntersect4);
  const Counted counted(Kind::kClosest, Form::kPacket, CountValid(valid, 4));
  next(valid, scene, context, rayhit);
}

RTC_API void rtcIntersect8(const int* valid, RTCScene scene, RTCIntersectContext* context,
                           RTCRayHit8* rayhit) {
  NEXT(rtcIntersect8);
  const Counted counted(Kind::kClosest, Form::kPacket, CountValid(valid, 8));
  next(valid, scene, context, rayhit);
}

RTC_API void rtcIntersect16(const int* valid, RTCScene scene, RTCIntersectContext* context,
                            RTCRayHit16* rayhit) {
  NEXT(rtcIntersect16);
  const Counted counted(Kind::kClosest, Form::kPacket, CountValid(valid, 16));
  next(valid, scene, context, rayhit);
}

RTC_API void rtcIntersect1M(RTCScene scene, RTCIntersectContext* context, RTCRayHit* rayhit,
                            unsigned int M, size_t byteStride) {
  NEXT(rtcIntersect1M);
  const Counted counted(Kind::kClosest, FormOfStream(M), M);
  next(scene, context, rayhit, M, byteStride);
}

RTC_API void rtcIntersect1Mp(RTCScene scene, RTCIntersectContext* context, RTCRayHit** rayhit,
                             unsigned int M) {
  NEXT(rtcIntersect1Mp);
  const Counted counted(Kind::kClosest, FormOfStream(M), M);
  next(scene, context, rayhit, M);
}

RTC_API void rtcIntersectNM(RTCScene scene, RTCIntersectContext* context, RTCRayHitN* rayhit,
                            unsigned int N, unsigned int M, size_t byteStride) {
  NEXT(rtcIntersectNM);
  const Counted counted(Kind::kClosest, FormOfStream(uint64_t{N} * M), uint64_t{N} * M);
  next(scene, context, rayhit, N, M, byteStride);
}

RTC_API void rtcIntersectNp(RTCScene scene, RTCIntersectContext* context, const RTCRayHitNp* rayhit,
                            unsigned int N) {
  NEXT(rtcIntersectNp);
  const Counted counted(Kind::kClosest, FormOfStream(N), N);
  next(scene, context, rayhit, N);
}

RTC_API void rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  NEXT(rtcOccluded1);
  const Counted counted(Kind::kAny, Form::kSingle, 1);
  next(scene, context, ray);
}

RTC_API void rtcOccluded4(const int* valid, RTCScene scene, RTCIntersectContext* context,
                          RTCRay4* ray) {
  NEXT(rtcOccluded4);
  const Counted counted(Kind::kAny, Form::kPacket, CountValid(valid, 4));
  next(valid, scene, context, ray);
}

RTC_API void rtcOccluded8(const int* valid, RTCScene scene, RTCIntersectContext* context,
                          RTCRay8* ray) {
  NEXT(rtcOccluded8);
  const Counted counted(Kind::kAny, Form::kPacket, CountValid(valid, 8));
  next(valid, scene, context, ray);
}

RTC_API void rtcOccluded16(const int* valid, RTCScene scene, RTCIntersectContext* context,
                           RTCRay16* ray) {
  NEXT(rtcOccluded16);
  const Counted counted(Kind::kAny, Form::kPacket, CountValid(valid, 16));
  next(valid, scene, context, ray);
}

RTC_API void rtcOccluded1M(RTCScene scene, RTCIntersectContext* context, RTCRay* ray,
                           unsigned int M, size_t byteStride) {
  NEXT(rtcOccluded1M);
  const Counted counted(Kind::kAny, FormOfStream(M), M);
  next(scene, context, ray, M, byteStride);
}

RTC_API void rtcOccluded1Mp(RTCScene scene, RTCIntersectContext* context, RTCRay** ray,
                            unsigned int M) {
  NEXT(rtcOccluded1Mp);
  const Counted counted(Kind::kAny, FormOfStream(M), M);
  next(scene, context, ray, M);
}

RTC_API void rtcOccludedNM(RTCScene scene, RTCIntersectContext* context, RTCRayN* ray,
                           unsigned int N, unsigned int M, size_t byteStride) {
  NEXT(rtcOccludedNM);
  const Counted counted(Kind::kAny, FormOfStream(uint64_t{N} * M), uint64_t{N} * M);
  next(scene, context, ray, N, M, byteStride);
}

RTC_API void rtcOccludedNp(RTCScene scene, RTCIntersectContext* context, const RTCRayNp* ray,
                           unsigned int N) {
  NEXT(rtcOccludedNp);
  const Counted counted(Kind::kAny, FormOfStream(N), N);
  next(scene, context, ray, N);
}

RTC_API bool rtcPointQuery(RTCScene scene, RTCPointQuery* query, RTCPointQueryContext* context,
                           RTCPointQueryFunction function, void* data) {
  NEXT(rtcPointQuery);
  const Counted counted(Kind::kPoint, Form::kSingle, 1);
  return next(scene, query, context, function, data);
}

RTC_API bool rtcPointQuery4(const int* valid, RTCScene scene, RTCPointQuery4* query,
                            RTCPointQueryContext* context, RTCPointQueryFunction function,
                            void** data) {
  NEXT(rtcPointQuery4);
  const Counted counted(Kind::kPoint, Form::kPacket, CountValid(valid, 4));
  return next(valid, scene, query, context, function, data);
}

RTC_API bool rtcPointQuery8(const int* valid, RTCScene scene, RTCPointQuery8* query,
                            RTCPointQueryContext* context, RTCPointQueryFunction function,
                            void** data) {
  NEXT(rtcPointQuery8);
  const Counted counted(Kind::kPoint, Form::kPacket, CountValid(valid, 8));
  return next(valid, scene, query, context, function, data);
}

RTC_API bool rtcPointQuery16(const int* valid, RTCScene scene, RTCPointQuery16* query,
                             RTCPointQueryContext* context, RTCPointQueryFunction function,
                             void** data) {
  NEXT(rtcPointQuery16);
  const Counted counted(Kind::kPoint, Form::kPacket, CountValid(valid, 16));
  return next(valid, scene, query, context, function, data);
}

}  // extern "C"
