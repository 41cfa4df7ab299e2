#include "campaign.h"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <deque>
#include <memory>
#include <ostream>
#include <sstream>
#include <utility>

#include "generator.h"
#include "isolation.h"
#include "shrink.h"
#include "world_text.h"

namespace dacrt::tests {
namespace {

/// Worlds that one process runs before it makes room for another: enough to make up for what its
/// start costs.
constexpr uint64_t kWorldsAProcess = 50;

/// Counts and failures on their way between processes, as lines: C, the kinds separated by tabs,
/// and the bytes of the tally in hexadecimal; or F, the seed and the reason; or D, the seed, when
/// a world is done.
class Message {
 public:
  static std::string OfCounts(const Report& report) {
    std::ostringstream text;
    for (const auto& [kinds, tally] : report.tallies()) {
      text << "C\t" << kinds.first << '\t' << kinds.second << '\t';
      unsigned char bytes[sizeof(Tally)];
      std::memcpy(bytes, &tally, sizeof(tally));
      for (const unsigned char byte : bytes) text << char('a' + byte / 16) << char('a' + byte % 16);
      text << '\n';
    }
    return text.str();
  }

  static void Read(const std::string& line, CampaignResult& result) {
    std::istringstream text(line);
    std::string what, first, second, rest;
    std::getline(text, what, '\t');
    std::getline(text, first, '\t');
    if (what == "D") {
      ++result.worlds;
    } else if (what == "F") {
      std::getline(text, rest);
      result.failures.push_back({std::stoull(first), rest});
    } else {
      std::getline(text, second, '\t');
      std::getline(text, rest);
      unsigned char bytes[sizeof(Tally)];
      for (std::size_t i = 0; i < sizeof(bytes); ++i) {
        bytes[i] = static_cast<unsigned char>((rest[2 * i] - 'a') * 16 + rest[2 * i + 1] - 'a');
      }
      Tally tally;
      std::memcpy(static_cast<void*>(&tally), bytes, sizeof(tally));
      result.report.At(first, second) += tally;
    }
  }
};

std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// The seeds that one process runs.
struct Share {
  uint64_t first, end;
};

std::unique_ptr<Isolated> Start(const Campaign& campaign, const Share& share) {
  return std::make_unique<Isolated>([&](const Isolated::Write& write, Progress& progress) {
    Arena arena = campaign.opponents.MakeArena();
    arena.Show(progress);
    for (uint64_t seed = share.first; seed < share.end; ++seed) {
      Isolated::StartStep();
      progress.seed = seed;
      Report report;
      const std::optional<Failure> failure =
          RunSeed(arena, seed, campaign.features, campaign.rays, report);
      write(Message::OfCounts(report));
      if (failure) {
        write("F\t" + std::to_string(seed) + '\t' + OneLine(failure->finding.reason) + '\n');
      }
      write("D\t" + std::to_string(seed) + '\n');
    }
  });
}

/// How a process ended in the middle of the work.
std::string ReasonOf(const Ending& ending) {
  return std::string(Name(ending.progress.in_real_library ? Library::kReal : Library::kDropIn)) +
         " ends the process with " +
         (ending.signal ? "signal " + std::to_string(ending.signal)
                        : "exit code " + std::to_string(ending.exit_code));
}

/// Runs a world in a process of its own. Writes what is wrong, and then tells it; nothing if it is
/// as it should be.
std::optional<Finding> RunIsolated(const Opponents& opponents, const World& world, Report& report) {
  Isolated process([&](const Isolated::Write& write, Progress& progress) {
    Arena arena = opponents.MakeArena();
    arena.Show(progress);
    Report counts;
    const std::optional<Failure> failure = RunWorld(arena, world, counts);
    write(Message::OfCounts(counts));
    if (failure) write("F\t0\t" + OneLine(failure->finding.reason) + '\n');
    if (failure) write(failure->finding.description);
  });
  const Ending ending = process.Wait();
  if (!ending.IsDone()) return Finding{ReasonOf(ending), "", 0};
  CampaignResult result;
  std::istringstream text(ending.output);
  std::string line, description;
  while (std::getline(text, line)) {
    if (!result.failures.empty()) {
      description += line + '\n';
    } else {
      Message::Read(line, result);
    }
  }
  for (const auto& [kinds, tally] : result.report.tallies()) {
    report.At(kinds.first, kinds.second) += tally;
  }
  if (result.failures.empty()) return std::nullopt;
  return Finding{result.failures.front().reason, description, 0};
}

/// Whether two findings are likely to have one reason: the same library does the same wrong.
bool AreAlike(const std::string& a, const std::string& b) {
  constexpr std::size_t kTellingLength = 24;
  return a.compare(0, kTellingLength, b, 0, kTellingLength) == 0;
}

/// The world of a seed with the rays of all batches, and only the batch that fails if that is
/// known.
World FailingWorld(const Campaign& campaign, uint64_t seed) {
  Isolated process([&](const Isolated::Write& write, Progress& progress) {
    Arena arena = campaign.opponents.MakeArena();
    arena.Show(progress);
    Report report;
    const auto show = [&](const World& world) {
      std::ostringstream text;
      Write(text, world);
      write("W\n" + text.str());
    };
    RunSeed(arena, seed, campaign.features, campaign.rays, report, show);
  });
  // The last one that was shown before the end.
  const std::string output = process.Wait().output;
  std::istringstream text(output.substr(output.rfind("W\n") + 2));
  return ReadWorld(text);
}

}  // namespace

Arena Opponents::MakeArena() const {
  return real_alone ? Arena::OfRealAlone(*real_alone) : Arena(drop_in_config);
}

CampaignResult RunCampaign(const Campaign& campaign) {
  const auto start = std::chrono::steady_clock::now();
  const auto is_over = [&](const CampaignResult& result) {
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    return elapsed.count() > campaign.seconds || result.failures.size() >= campaign.most_failures;
  };
  struct Running {
    Share share;
    std::unique_ptr<Isolated> process;
  };
  CampaignResult result;
  std::deque<Share> shares;
  for (uint64_t done = 0; done < campaign.worlds; done += kWorldsAProcess) {
    const uint64_t first = campaign.first_seed + done;
    shares.push_back({first, first + std::min(kWorldsAProcess, campaign.worlds - done)});
  }
  std::vector<Running> running;
  while (!running.empty() || (!shares.empty() && !is_over(result))) {
    while (running.size() < campaign.processes && !shares.empty() && !is_over(result)) {
      running.push_back({shares.front(), Start(campaign, shares.front())});
      shares.pop_front();
    }
    std::vector<pollfd> waits;
    for (const Running& one : running) waits.push_back({one.process->descriptor(), POLLIN, 0});
    poll(waits.data(), waits.size(), -1);
    for (std::size_t i = running.size(); i-- > 0;) {
      if (waits[i].revents == 0 || running[i].process->Read()) continue;
      const Ending ending = running[i].process->Wait();
      std::istringstream text(ending.output);
      for (std::string line; std::getline(text, line);) Message::Read(line, result);
      if (!ending.IsDone()) {
        const uint64_t seed = ending.progress.seed;
        if (ending.progress.in_real_library || campaign.opponents.real_alone) {
          result.ended_by_real.push_back(seed);
        } else {
          result.failures.push_back({seed, ReasonOf(ending)});
        }
        if (seed + 1 < running[i].share.end) shares.push_front({seed + 1, running[i].share.end});
      }
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  return result;
}

std::optional<std::string> ReplayWorld(const Opponents& opponents, const World& world,
                                       Report& report) {
  const std::optional<Finding> finding = RunIsolated(opponents, world, report);
  if (!finding) return std::nullopt;
  return finding->reason + '\n' + finding->description;
}

void PrintFailure(std::ostream& out, const Campaign& campaign, uint64_t seed) {
  World world = FailingWorld(campaign, seed);
  Report unused;
  const auto run = [&](const World& candidate) {
    return RunIsolated(campaign.opponents, candidate, unused);
  };
  std::optional<Finding> finding = run(world);
  if (!finding) {
    out << "# seed " << seed << " fails only after what the process did before\n";
    return;
  }
  const std::string reason = finding->reason;
  world = Shrink(world, [&](const World& candidate) {
    std::optional<Finding> other = run(candidate);
    if (!other || !AreAlike(reason, other->reason)) return false;
    finding = std::move(other);
    return true;
  });
  out << "# seed " << seed << ": " << finding->reason << '\n';
  std::istringstream description(finding->description);
  for (std::string line; std::getline(description, line);) out << "#" << line << '\n';
  Write(out, world);
}

}  // namespace dacrt::tests
