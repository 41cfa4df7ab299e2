// differential_run: as many random worlds as wanted through both libraries, a table of what
// differed, and of each failure a small world that shows it.
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>

#include "campaign.h"
#include "world_text.h"

namespace dacrt::tests {
namespace {

constexpr const char* kUsage = R"(usage: differential_run [OPTION]...
Makes random scenes and rays, gives them to the real Embree and to the drop-in, and explains every
difference. What is not explained is shrunk and printed; kept as a file, it can be run again.

  --scenes=N         how many worlds of scenes (default 100)
  --rays=N           about how many rays for each of them (default 10000)
  --seed=S           the first world's seed, the others' follow it (default 1)
  --seconds=T        no more worlds after this time
  --features=LIST    what worlds may hold, e.g. triangles,quads,motion; or what not, e.g. -user
                     (default: everything; --list-features names all)
  --config=TEXT      configuration of the drop-in's device
  --real-alone=TEXT  the real library, so configured, in place of the drop-in
  --processes=N      at once (default: one for each thread of the machine)
  --failures=N       ends after so many (default 5)
  --replay=FILE      runs a kept world, and nothing else
  --list-features    names all features and ends

The exit code is 0 if every difference is explained, 1 if one is not, 2 for a wrong option.
)";

struct Options {
  Campaign campaign;
  std::string replay;
  bool list_features = false;
};

std::size_t ParseCount(const std::string& value) {
  const double count = std::stod(value);
  if (!(count >= 0 && count <= 1e15)) throw std::out_of_range(value);
  return static_cast<std::size_t>(count);
}

/// Throws std::logic_error for an option that is not known or a value that cannot be read.
void ParseOption(std::string_view argument, Options& options) {
  Campaign& campaign = options.campaign;
  const std::size_t equals = argument.find('=');
  const std::string_view name = argument.substr(0, equals);
  const std::string value(equals == std::string_view::npos ? "" : argument.substr(equals + 1));
  if (name == "--scenes") {
    campaign.worlds = ParseCount(value);
  } else if (name == "--rays") {
    campaign.rays = ParseCount(value);
  } else if (name == "--seed") {
    campaign.first_seed = std::stoull(value);
  } else if (name == "--seconds") {
    campaign.seconds = std::stod(value);
  } else if (name == "--features") {
    campaign.features = ParseFeatures(value);
  } else if (name == "--config") {
    campaign.opponents.drop_in_config = value;
  } else if (name == "--real-alone") {
    campaign.opponents.real_alone = value;
  } else if (name == "--processes") {
    campaign.processes = static_cast<unsigned>(std::max<std::size_t>(1, ParseCount(value)));
  } else if (name == "--failures") {
    campaign.most_failures = ParseCount(value);
  } else if (name == "--replay") {
    options.replay = value;
  } else if (argument == "--list-features") {
    options.list_features = true;
  } else {
    throw std::invalid_argument(value);
  }
}

/// Throws std::invalid_argument that names what is wrong.
Options ParseOptions(int argc, char** argv) {
  Options options;
  options.campaign.features.set();
  options.campaign.processes = std::max(1u, std::thread::hardware_concurrency());
  for (int i = 1; i < argc; ++i) {
    try {
      ParseOption(argv[i], options);
    } catch (const std::logic_error&) {
      throw std::invalid_argument(argv[i]);
    }
  }
  return options;
}

int Replay(const Options& options) {
  std::ifstream file(options.replay);
  if (!file) throw std::invalid_argument("--replay=" + options.replay);
  const World world = ReadWorld(file);
  Report report;
  const std::optional<std::string> fault = ReplayWorld(options.campaign.opponents, world, report);
  if (fault) std::cout << *fault << '\n';
  report.PrintTable(std::cout);
  return fault ? 1 : 0;
}

int Run(const Options& options) {
  if (options.list_features) {
    for (unsigned i = 0; i < kFeatureCount; ++i) {
      std::cout << Name(static_cast<Feature>(i)) << '\n';
    }
    return 0;
  }
  if (!options.replay.empty()) return Replay(options);

  const CampaignResult result = RunCampaign(options.campaign);
  result.report.PrintTable(std::cout);
  std::cout << '\n' << result.worlds << " worlds";
  if (!result.ended_by_real.empty()) {
    std::cout << "; the real library ended the process over " << result.ended_by_real.size()
              << " more, seeds";
    for (const uint64_t seed : result.ended_by_real) std::cout << ' ' << seed;
  }
  std::cout << '\n' << result.failures.size() << " failures\n" << std::flush;
  for (const auto& failure : result.failures) {
    std::cout << "\nseed " << failure.seed << ": " << failure.reason << '\n' << std::flush;
    PrintFailure(std::cout, options.campaign, failure.seed);
    std::cout << std::flush;
  }
  return result.failures.empty() ? 0 : 1;
}

}  // namespace
}  // namespace dacrt::tests

int main(int argc, char** argv) {
  try {
    return dacrt::tests::Run(dacrt::tests::ParseOptions(argc, argv));
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "differential_run: wrong argument: %s\n%s", error.what(),
                 dacrt::tests::kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "differential_run: %s\n", error.what());
    return 2;
  }
}
