// conformance_run: as many rays as wanted through both libraries, and a table of what differed.
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "contest.h"

namespace dacrt::tests {
namespace {

constexpr const char* kUsage = R"(usage: conformance_run [OPTION]...
Traces the same rays with the real Embree and with the drop-in, and explains every difference.

  --rays=N           about how many rays in all, e.g. 40e6 (default 10e6)
  --scene=TEXT       only scenes whose names contain TEXT
  --seed=N           another seed gives other rays (default 1)
  --config=TEXT      configuration of the drop-in's device
  --real-config=TEXT configuration of the real library's device; may be given several times
                     (default: once isa=avx2, once the library's own choice)
  --json=FILE        also writes the counts there
  --list             prints the names of the scenes and ends

The exit code is 0 if every difference is explained, 1 if one is not, 2 for a wrong option.
)";

struct Options {
  std::size_t rays = 10'000'000;
  std::string scene;
  uint64_t seed = 1;
  std::string config;
  std::vector<std::string> real_configs;
  std::string json;
  bool list = false;
};

/// Throws std::logic_error for an option that is not known or a value that cannot be read.
void ParseOption(std::string_view argument, Options& options) {
  const std::size_t equals = argument.find('=');
  const std::string_view name = argument.substr(0, equals);
  const std::string value(equals == std::string_view::npos ? "" : argument.substr(equals + 1));
  if (name == "--rays") {
    const double rays = std::stod(value);
    if (!(rays >= 0 && rays <= 1e15)) throw std::out_of_range(value);
    options.rays = static_cast<std::size_t>(rays);
  } else if (name == "--scene") {
    options.scene = value;
  } else if (name == "--seed") {
    options.seed = std::stoull(value);
  } else if (name == "--config") {
    options.config = value;
  } else if (name == "--real-config") {
    options.real_configs.push_back(value);
  } else if (name == "--json") {
    options.json = value;
  } else if (argument == "--list") {
    options.list = true;
  } else {
    throw std::invalid_argument(value);
  }
}

/// Throws std::invalid_argument that names what is wrong.
Options ParseOptions(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    try {
      ParseOption(argv[i], options);
    } catch (const std::logic_error&) {
      throw std::invalid_argument(argv[i]);
    }
  }
  if (options.real_configs.empty()) options.real_configs = {"isa=avx2", ""};
  return options;
}

std::vector<SceneSource> ChosenScenes(const std::string& name_part) {
  std::vector<SceneSource> chosen;
  for (SceneSource& source : AllScenes()) {
    if (source.name.find(name_part) != std::string::npos) chosen.push_back(std::move(source));
  }
  return chosen;
}

/// Overwrites one line on a terminal; silent elsewhere.
void PrintProgress(const std::string& text) {
  if (isatty(STDERR_FILENO)) std::fprintf(stderr, "\r\x1b[K%s", text.c_str());
}

int Run(const Options& options) {
  const std::vector<SceneSource> sources = ChosenScenes(options.scene);
  if (options.list) {
    for (const SceneSource& source : sources) std::cout << source.name << '\n';
    return 0;
  }
  if (sources.empty()) throw std::invalid_argument("--scene=" + options.scene);

  const auto start = std::chrono::steady_clock::now();
  const Devices devices(options.config, options.real_configs);
  Report report;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const TestScene scene = sources[i].make();
    Contest contest(devices, scene, report);
    contest.CompareEverything(
        options.rays / sources.size(), options.seed, [&](const std::string& step) {
          const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
          char text[64];
          std::snprintf(text, sizeof(text), "%4.0f s, scene %zu of %zu: ", elapsed.count(), i + 1,
                        sources.size());
          PrintProgress(text + step);
        });
  }
  PrintProgress("");
  report.PrintExamples(std::cout);
  report.PrintTable(std::cout);
  if (!options.json.empty()) {
    std::ofstream file(options.json);
    report.PrintJson(file);
    if (!file) throw std::runtime_error(options.json + " cannot be written");
  }
  return report.Total().Count(Relation::kUnexplained) == 0 ? 0 : 1;
}

}  // namespace
}  // namespace dacrt::tests

int main(int argc, char** argv) {
  try {
    return dacrt::tests::Run(dacrt::tests::ParseOptions(argc, argv));
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "conformance_run: wrong argument: %s\n%s", error.what(),
                 dacrt::tests::kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "conformance_run: %s\n", error.what());
    return 2;
  }
}
