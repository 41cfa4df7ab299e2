// soak_run: random acts on several threads at once, for as long as wanted; ends at the first wrong
// answer, error, hang, or growth.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "acts.h"
#include "memory_figures.h"
#include "random.h"

namespace dacrt::tests {
namespace {

constexpr const char* kUsage = R"(usage: soak_run [OPTION]...
Makes scenes of all kinds, changes, traces and releases them on several threads at once, and compares
every answer with one that was got in another way.

  --minutes=M   how long (default 1)
  --rounds=N    so many rounds instead: what a round does depends on the seed only
  --seed=S      (default 1)
  --threads=N   (default 8)
  --acts=N      of a thread in a round (default 20)
  --act=S       only the act that a message names, by one thread

After each round all is released, and what the process takes is measured: neither what is in use then
nor the most in a round may grow, once there are twelve rounds. The exit code is 0 if all was well, 1 if not, 2 for a wrong option.
)";

/// A round that takes longer hangs.
constexpr unsigned kMostSecondsOfARound = 1200;

/// What may be in use after a round beyond what was after the first third of all: threads that end
/// leave some to those that start.
constexpr std::size_t kHeapSlack = 1 << 20;

/// How much more the later rounds may hold at most than the earlier ones: what acts meet is chance.
constexpr double kPeakSlack = 1.15;

struct Options {
  double minutes = 1;
  uint64_t rounds = std::numeric_limits<uint64_t>::max();
  uint64_t seed = 1, threads = 8, acts = 20;
  std::optional<uint64_t> only_act;
};

Options Parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    const std::size_t equals = argument.find('=');
    if (equals == std::string_view::npos) throw std::invalid_argument(argv[i]);
    const std::string_view name = argument.substr(0, equals);
    const std::string value(argument.substr(equals + 1));
    if (name == "--minutes") {
      options.minutes = std::stod(value);
    } else if (name == "--rounds") {
      options.rounds = std::stoull(value);
      options.minutes = std::numeric_limits<double>::infinity();
    } else if (name == "--seed") {
      options.seed = std::stoull(value);
    } else if (name == "--threads") {
      options.threads = std::stoull(value);
    } else if (name == "--acts") {
      options.acts = std::stoull(value);
    } else if (name == "--act") {
      options.only_act = std::stoull(value);
    } else {
      throw std::invalid_argument(argv[i]);
    }
  }
  return options;
}

struct Figures {
  std::size_t heap, peak;
};

/// All threads' acts. Throws what the first of them threw.
void RunRound(const Acts& acts, const Options& options, uint64_t round) {
  std::vector<std::exception_ptr> faults(options.threads);
  {
    std::vector<std::jthread> threads;
    for (uint64_t t = 0; t < options.threads; ++t) {
      threads.emplace_back([&, t] {
        try {
          for (uint64_t i = 0; i < options.acts; ++i) {
            acts.Act(SeedFor("act", options.seed + (round << 40) + (t << 20) + i));
          }
        } catch (...) {
          faults[t] = std::current_exception();
        }
      });
    }
  }
  for (const std::exception_ptr& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
}

/// Throws std::runtime_error if the later rounds take more than the earlier ones.
void CheckGrowth(const std::vector<Figures>& rounds) {
  constexpr std::size_t kFewRounds = 12;  // chance decides
  if (rounds.size() < kFewRounds) return;
  const std::size_t third = rounds.size() / 3;
  const auto most = [&](std::size_t first, std::size_t end, std::size_t Figures::*figure) {
    std::size_t most = 0;
    for (std::size_t i = first; i < end; ++i) most = std::max(most, rounds[i].*figure);
    return most;
  };
  const std::size_t heap_before = most(0, third, &Figures::heap);
  const std::size_t heap_after = most(rounds.size() - third, rounds.size(), &Figures::heap);
  if (heap_after > heap_before + kHeapSlack) {
    throw std::runtime_error("what is in use between rounds has grown from " +
                             std::to_string(heap_before) + " to " + std::to_string(heap_after));
  }
  const std::size_t peak_before = most(0, rounds.size() / 2, &Figures::peak);
  const std::size_t peak_after = most(rounds.size() / 2, rounds.size(), &Figures::peak);
  if (static_cast<double>(peak_after) > kPeakSlack * static_cast<double>(peak_before)) {
    throw std::runtime_error("the most that is held in a round has grown from " +
                             std::to_string(peak_before) + " to " + std::to_string(peak_after));
  }
}

void Run(const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  const auto minutes = [&] {
    return std::chrono::duration<double, std::ratio<60>>(std::chrono::steady_clock::now() - start)
        .count();
  };
  const Acts acts(options.seed);
  if (options.only_act) return acts.Act(*options.only_act);
  std::vector<Figures> rounds;
  TakePeakMemory();
  while (rounds.size() < options.rounds && minutes() < options.minutes) {
    alarm(kMostSecondsOfARound);
    RunRound(acts, options, rounds.size());
    rounds.push_back({HeapInUse(), TakePeakMemory()});
    std::printf("round %zu, %.1f minutes: %.2f MB in use, at most %.1f MB held\n", rounds.size(),
                minutes(), static_cast<double>(rounds.back().heap) / 1e6,
                static_cast<double>(rounds.back().peak) / 1e6);
    std::fflush(stdout);
  }
  std::printf(
      "%zu rounds in %.1f minutes: %zu times standing scenes, %zu worlds, %zu splits, %zu times "
      "memory"
      " refused, %zu times handles; %zu rays compared, %zu calls failed for want of memory\n",
      rounds.size(), minutes(), acts.Count(Acts::kAskStanding), acts.Count(Acts::kPlayWorld),
      acts.Count(Acts::kSplitAnew), acts.Count(Acts::kRefuseMemory), acts.Count(Acts::kChurn),
      acts.rays(), acts.refusals());
  CheckGrowth(rounds);
}

}  // namespace
}  // namespace dacrt::tests

int main(int argc, char** argv) {
  dacrt::tests::Options options;
  try {
    options = dacrt::tests::Parse(argc, argv);
  } catch (const std::logic_error& error) {
    std::fprintf(stderr, "soak_run: wrong argument: %s\n%s", error.what(), dacrt::tests::kUsage);
    return 2;
  }
  try {
    dacrt::tests::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "soak_run: %s\n", error.what());
    return 1;
  }
  return 0;
}
