#include "lidar/options.h"

#include <CLI/CLI.hpp>

#include "ambient_occlusion/program.h"

namespace lidar {
namespace {

constexpr char kDescription[] =
    "Drives a laser scanner down a street, behind a van, and writes what it has seen: a point "
    "cloud "
    "and a picture of it.";

constexpr char kFooter[] = R"(
Ctrl-C ends the drive: what was scanned until then is written.

Exit codes: 0 written, 2 bad command line, 4 cloud or picture cannot be written, 6 out of memory,
1 anything else.)";

}  // namespace

std::optional<Options> ParseOptions(int argc, char** argv) {
  Options options;
  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(30);
  app.add_option("--sweeps", options.sweeps, "Turns of the scanner")
      ->check(CLI::Range(1u, 22u))  // that is how long the street is
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--rays", options.rays, "Rays a sweep")
      ->check(CLI::Range(64u, 64'000'000u))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--seed", options.seed, "Another seed, another street")
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--threads", options.threads, "Threads, 0 for all")
      ->check(CLI::Range(0u, 1024u))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("-o,--cloud", options.cloud, "Points to write: .ply")
      ->capture_default_str()
      ->type_name("FILE");
  app.add_option("--picture", options.picture, "Picture to write: .png, .jpg, .jpeg or .exr")
      ->capture_default_str()
      ->type_name("FILE");
  if (!ao::ParseCommandLine(app, argc, argv)) return std::nullopt;
  return options;
}

}  // namespace lidar
