// Programs whose address space ends, from the first call on, a little later in each run: what
// cannot be had, memory, mappings or threads, is reported, and is there once there is room again.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <string>

#include "in_process.h"
#include "sanitized.h"
#include "step_program.h"

namespace dacrt::tests {
namespace {

const char* const kOneThread = "threads=1";

/// Of the address space, what this process has taken.
std::size_t BytesMapped() {
  std::size_t pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

/// The end of the address space, or none.
void Limit(std::size_t bytes) {
  rlimit limit;
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = bytes;
  setrlimit(RLIMIT_AS, &limit);
}

/// Lets the stack grow now: where it cannot later, any program ends.
[[gnu::noinline]] void TouchStack() {
  volatile char stack[2 << 20];
  for (std::size_t i = 0; i < sizeof(stack); i += 4096) stack[i] = 1;
}

struct Outcome {
  std::size_t refused = 0;  ///< steps that could not be done
  std::size_t step = 0;     ///< where the complaint is about
  const char* complaint = nullptr;
  /// A thread of oneTBB's that begins where there is no memory throws where nobody catches.
  bool ended_by_onetbb = false;
};

/// Runs all steps with `more` bytes beyond what the process has.
void RunProgram(const char* config, std::size_t more, Outcome& outcome) {
  StepProgram program(config);
  const auto steps = program.Steps();
  const std::size_t end = BytesMapped() + more;
  for (outcome.step = 0; outcome.step < steps.size(); ++outcome.step) {
    Limit(end);
    const bool is_done = steps[outcome.step]();
    const RTCError error = program.TakeError();
    Limit(RLIM_INFINITY);
    if (error == RTC_ERROR_NONE && is_done) continue;
    ++outcome.refused;
    if (error == RTC_ERROR_NONE) {
      outcome.complaint = "failed in silence";
    } else if (error != RTC_ERROR_OUT_OF_MEMORY) {
      outcome.complaint = "an error of another kind";
    } else if (!steps[outcome.step]() || program.TakeError() != RTC_ERROR_NONE) {
      outcome.complaint = "fails again though there is room";
    }
    if (outcome.complaint) return;
  }
  program.Release();
}

/// The same in a process of its own, in which no thread was started yet.
Outcome RunAlone(const char* config, std::size_t more) {
  Outcome outcome;
  const Ending ending = RunInProcess(outcome, [&](Outcome& own) {
    TouchStack();
    RunProgram(config, more, own);
  });
  if (ending.Signal() == SIGABRT && config != kOneThread) {
    outcome.ended_by_onetbb = true;
  } else if (const char* const complaint = ending.Complaint()) {
    outcome.complaint = complaint;
  }
  return outcome;
}

class AddressSpace : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, AddressSpace, testing::Values(kOneThread, "threads=2"),
                         [](const auto& info) { return info.index == 0 ? "one" : "two"; });

// Where oneTBB had no room to start, the next call waited for ever; where a thread could not be
// started, the error was unknown, not one of memory.
TEST_P(AddressSpace, WhatCannotBeHadIsReportedAndThereLater) {
  if (DACRT_TEST_SANITIZED) GTEST_SKIP() << "the sanitizer takes the address space itself";
  constexpr std::size_t kMost = 20 << 20, kStep = 160 << 10;  // a thread's stack has 8 MB
  std::size_t runs = 0, refused = 0, ended = 0;
  for (std::size_t more = 0; more < kMost; more += kStep) {
    const Outcome outcome = RunAlone(GetParam(), more);
    EXPECT_STREQ(outcome.complaint, nullptr) << more << " bytes, step " << outcome.step;
    ++runs;
    refused += outcome.refused;
    ended += outcome.ended_by_onetbb;
  }
  EXPECT_GT(refused, 20u);
  EXPECT_LT(ended, runs / 10);
  testing::Test::RecordProperty("refused", static_cast<int>(refused));
}

}  // namespace
}  // namespace dacrt::tests
