// Many worlds, on several processes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "feature_set.h"
#include "report.h"
#include "run.h"

namespace dacrt::tests {

/// Which libraries meet.
struct Opponents {
  std::string drop_in_config;
  /// The real library with this configuration in place of the drop-in: shows whether the rules of
  /// comparison hold.
  std::optional<std::string> real_alone;

  Arena MakeArena() const;
};

struct Campaign {
  Opponents opponents;
  Features features;
  uint64_t first_seed = 1;
  uint64_t worlds = 100;
  double seconds = std::numeric_limits<double>::infinity();  ///< no more worlds after that
  std::size_t rays = 10'000;                                 ///< of a world
  unsigned processes = 1;
  std::size_t most_failures = 5;  ///< ends then
};

struct CampaignResult {
  struct FailedSeed {
    uint64_t seed;
    std::string reason;
  };
  Report report;
  uint64_t worlds = 0;
  std::vector<FailedSeed> failures;
  /// Worlds over which the real library ended the process; they are not counted otherwise.
  std::vector<uint64_t> ended_by_real;
};

CampaignResult RunCampaign(const Campaign& campaign);

/// Runs the world of a failed seed again, shrinks it, and prints what is left as text that can be
/// kept (see world_text.h), with what goes wrong in remarks.
void PrintFailure(std::ostream& out, const Campaign& campaign, uint64_t seed);

/// Why a kept world fails; nothing if it does not.
std::optional<std::string> ReplayWorld(const Opponents& opponents, const World& world,
                                       Report& report);

}  // namespace dacrt::tests
