// Every allocation and every mapping of a program's calls is made to fail, one after the other, and
// all from one on, each in a process of its own: a call works, or reports that there is no memory
// and works when there is some again. Nothing hangs, ends the process, or is left behind.
#include <embree3/rtcore.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "in_process.h"
#include "sanitized.h"
#include "step_program.h"

namespace {

/// What the allocator below refuses while it is armed: allocation `first`, and those after it, too,
/// if `all`.
struct Refusals {
  bool armed = false;
  long first = LONG_MAX;
  bool all = false;
  long count = 0;

  bool Next() {
    if (!armed) return false;
    const long number = count++;
    return number == first || (all && number > first);
  }
} refusals;

/// Blocks of the heap that are in use.
long blocks = 0;

}  // namespace

#if !DACRT_TEST_SANITIZED
// Libraries are to find them: Clang hides them otherwise.
#pragma GCC visibility push(default)
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

static void* Refuse() {
  errno = ENOMEM;
  return nullptr;
}

static void* Count(void* memory) {
  blocks += memory != nullptr;
  return memory;
}

void* malloc(std::size_t bytes) { return refusals.Next() ? Refuse() : Count(__libc_malloc(bytes)); }
void* calloc(std::size_t count, std::size_t bytes) {
  return refusals.Next() ? Refuse() : Count(__libc_calloc(count, bytes));
}
void* realloc(void* memory, std::size_t bytes) {
  if (refusals.Next()) return Refuse();
  return memory ? __libc_realloc(memory, bytes) : Count(__libc_realloc(memory, bytes));
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  return refusals.Next() ? Refuse() : Count(__libc_memalign(alignment, bytes));
}
void free(void* memory) {
  blocks -= memory != nullptr;
  __libc_free(memory);
}
void* memalign(std::size_t alignment, std::size_t bytes) { return aligned_alloc(alignment, bytes); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) {
  *memory = aligned_alloc(alignment, bytes);
  return *memory ? 0 : ENOMEM;
}
void* mmap(void* address, std::size_t bytes, int protection, int flags, int file, off_t offset) {
  if (refusals.Next()) {
    errno = ENOMEM;
    return MAP_FAILED;
  }
  const long mapped = syscall(SYS_mmap, address, bytes, protection, flags, file, offset);
  return reinterpret_cast<void*>(mapped);
}

}  // extern "C"
#pragma GCC visibility pop
#endif

namespace {

using dacrt::tests::Ending;
using dacrt::tests::RunInProcess;
using dacrt::tests::StepProgram;

/// What a process says of its run.
struct Outcome {
  long allocations = 0;  ///< of the step that was armed
  const char* complaint = nullptr;
  long left_blocks = 0;  ///< of the heap
};

/// Runs the program with refusals in step `armed`, or in none.
Outcome RunProgram(const char* config, std::size_t armed, long first, bool all) {
  Outcome outcome;
  const long before = blocks;
  rtcNewDevice("threads=none");
  if (rtcGetDeviceError(nullptr) != RTC_ERROR_UNKNOWN) outcome.complaint = "no error";
  {
    StepProgram program(config);
    const auto steps = program.Steps();
    for (std::size_t i = 0; i < steps.size(); ++i) {
      refusals = {i == armed, first, all, 0};
      bool is_done = steps[i]();
      if (i == armed && i > 3) {
        // What is wrong is called so, also where there is no memory.
        const RTCError error = program.TakeError();
        program.MakeArgumentError();
        const RTCError wrong = program.TakeError();
        refusals.armed = false;
        if (wrong != RTC_ERROR_INVALID_ARGUMENT) outcome.complaint = "another code";
        if (error != RTC_ERROR_NONE && error != RTC_ERROR_OUT_OF_MEMORY) {
          outcome.complaint = "an error of another kind";
        }
        if (error == RTC_ERROR_NONE && !is_done) outcome.complaint = "failed in silence";
        if (error != RTC_ERROR_NONE) is_done = false;
      } else if (i == armed) {
        refusals.armed = false;
        const RTCError error = program.TakeError();
        if (error != (is_done ? RTC_ERROR_NONE : RTC_ERROR_OUT_OF_MEMORY)) {
          outcome.complaint = "an error of another kind";
        }
      }
      if (i == armed) outcome.allocations = refusals.count;
      if (is_done) continue;
      if (i != armed) {
        outcome.complaint = "fails though there is memory";
      } else if (!steps[i]()) {
        outcome.complaint = "fails again though there is memory";
      }
    }
    if (program.TakeError() != RTC_ERROR_NONE) outcome.complaint = "an error without refusals";
    program.MakeArgumentError();
    if (program.TakeError() != RTC_ERROR_INVALID_ARGUMENT) outcome.complaint = "no error";
    // The end, too, must do without memory.
    refusals = {armed == SIZE_MAX - 1, 0, true, 0};
    program.Release();
    refusals.armed = false;
  }
  outcome.left_blocks = blocks - before;
  return outcome;
}

/// The same in a process of its own.
Outcome RunAlone(const char* config, std::size_t armed, long first, bool all) {
  Outcome outcome;
  outcome.complaint = "ended";
  const Ending ending = RunInProcess(outcome, [&](Outcome& own) {
    RunProgram(config, SIZE_MAX, 0,
               false);  // what libraries keep once they were used is there then
    own = RunProgram(config, armed, first, all);
  });
  if (const char* const complaint = ending.Complaint()) outcome.complaint = complaint;
  return outcome;
}

/// Fails if one of the program's steps cannot do without one allocation, or without those from one
/// on.
void ExpectSurvivesEveryRefusal(const char* config, bool all) {
  if (DACRT_TEST_SANITIZED) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  const Outcome undisturbed = RunAlone(config, SIZE_MAX, 0, false);
  ASSERT_EQ(undisturbed.complaint, nullptr);
  ASSERT_EQ(undisturbed.left_blocks, 0);
  const std::size_t steps = StepProgram(config).Steps().size();
  std::size_t runs = 0;
  for (std::size_t step = 0; step < steps; ++step) {
    const long allocations = RunAlone(config, step, LONG_MAX, false).allocations;
    for (long first = 0; first < allocations; ++first, ++runs) {
      const Outcome outcome = RunAlone(config, step, first, all);
      EXPECT_STREQ(outcome.complaint, nullptr)
          << "step " << step << ", allocation " << first << " of " << allocations;
      EXPECT_EQ(outcome.left_blocks, 0)
          << "step " << step << ", allocation " << first << " of " << allocations;
    }
  }
  EXPECT_GT(runs, 200u);
  testing::Test::RecordProperty("runs", static_cast<int>(runs));
}

class OutOfMemory : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, OutOfMemory, testing::Values("threads=1", "threads=2"),
                         [](const auto& info) { return info.index == 0 ? "one" : "two"; });

// An allocation that failed while an object was entered into the table of handles ended the object
// under the table's lock, which its destructor waits for.
TEST_P(OutOfMemory, ASingleRefusalNeitherHangsNorIsFeltLater) {
  ExpectSurvivesEveryRefusal(GetParam(), false);
}

// What reports errors allocated: without any memory std::bad_alloc left the functions.
TEST_P(OutOfMemory, NothingIsThrownWhereThereIsNoMemoryAtAll) {
  ExpectSurvivesEveryRefusal(GetParam(), true);
}

// Objects end without memory: giving workspaces back took some.
TEST_P(OutOfMemory, EverythingIsReleasedWithoutMemory) {
  if (DACRT_TEST_SANITIZED) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  EXPECT_STREQ(RunAlone(GetParam(), SIZE_MAX - 1, 0, true).complaint, nullptr);
}

// The first to ask for the table of buffers was one that ended.
TEST(OutOfMemoryAtTheEnd, BuffersThatHaveNoHandleEndWithoutMemory) {
  if (DACRT_TEST_SANITIZED) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  Outcome nothing;
  const Ending ending = RunInProcess(nothing, [](Outcome&) {
    static float vertices[9];
    const RTCDevice device = rtcNewDevice("threads=1");
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                               12, 3);
    refusals = {true, 0, true, 0};
    rtcReleaseGeometry(geometry);
    rtcReleaseDevice(device);
    refusals.armed = false;
  });
  EXPECT_STREQ(ending.Complaint(), nullptr);
}

}  // namespace
