// What the calls of a program are counted in: memory that the counting library and dacrt-compare
// share, so that a program that crashes or leaves in a hurry has been counted, too.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace dacrt::compare {

inline constexpr char kCountsVariable[] = "DACRT_COUNT_FILE";  ///< of the environment: the file

enum class Kind : uint32_t { kClosest, kAny, kPoint, kCommit };
inline constexpr std::size_t kKinds = 4;

/// How rays are handed over, and how many a call.
enum class Form : uint32_t { kSingle, kPacket, kTo64, kTo1K, kTo4K, kTo64K, kTo1M, kMore };
inline constexpr std::size_t kForms = 8;

/// Most rays of a stream call of a form, from kTo64 on.
inline constexpr uint64_t kMostRays[] = {64, 1024, 4096, 65'536, 1 << 20};

inline Form FormOfStream(uint64_t rays) {
  std::size_t form = 0;
  while (form < std::size(kMostRays) && rays > kMostRays[form]) ++form;
  return static_cast<Form>(form + static_cast<std::size_t>(Form::kTo64));
}

/// Of one kind and form. A call from within a callback is counted, and its time is that of the call
/// that it is part of.
struct Counts {
  std::atomic<uint64_t> calls, rays, nanoseconds, inner_calls;
};

/// A thread's; later threads share the last.
struct alignas(64) ThreadCounts {
  Counts of[kKinds][kForms];
};

struct CountFile {
  static constexpr std::size_t kThreads = 128;

  std::atomic<uint32_t> threads;             ///< that have counted something
  std::atomic<uint32_t> devices;             ///< that were made
  std::atomic<uint32_t> refused_geometries;  ///< rtcNewGeometry gave none
  std::atomic<uint32_t> clock_nanoseconds;   ///< that two looks at the clock are apart
  char library[4096];                        ///< that answered the first rtcNewDevice
  ThreadCounts of[kThreads];
};
static_assert(std::atomic<uint64_t>::is_always_lock_free, "shared between processes");

}  // namespace dacrt::compare
