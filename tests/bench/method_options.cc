#include "method_options.h"

#include <CLI/CLI.hpp>

#include <set>
#include <stdexcept>

#include "command_line.h"
#include "errors.h"

namespace dacrt::bench {
namespace {

constexpr char kDescription[] =
    R"(Reproduces the results of Nabata et al., "Efficient Divide-And-Conquer Ray Tracing using Ray
Sampling", HPG 2013: scenes x kinds of frames x numbers of rays x algorithms, on one thread.
Making rays and shading are not measured.)";

constexpr char kFooter[] = R"(
A scene is one of hall-75k, hall-260k, hall-1m, hall-5m (generated), sibenik, sponza,
country_kitchen, terrain_white_mountains, dragon (PLY files in the folder of scenes), or any mesh
that Assimp reads. Scenes that nobody named and that are not there are left out.

Exit codes: 0 measured, 1 out of memory or another failure, 2 bad command line, 3 measured, but a
scene could not be read, 4 two methods found different hits, 5 an output cannot be written.)";

// What is measured where the command line does not say.
struct Extent {
  std::vector<std::string> scenes;
  std::vector<uint32_t> sides;  // of the rays
};

Extent ShortExtent() { return {{"hall-75k"}, {256, 512}}; }

Extent StandardExtent() {
  Extent extent{SceneNames(), {512, 1024}};
  std::erase(extent.scenes, "hall-5m");
  return extent;
}

Extent FullExtent() { return {SceneNames(), {512, 1024, 2048, 4096}}; }

// A setting changed alone: the parts of the method switched off, then its constants.
struct Change {
  const char* name;
  const char* value;
};
constexpr Change kAblation[] = {
    {"sampled_cost", "0"},
    {"sampled_order", "0"},
    {"skip_filtering", "0"},
    {"sample_rays", "25"},
    {"sample_rays", "50"},
    {"sample_rays", "200"},
    {"sample_rays", "400"},
    {"sample_threshold", "250"},
    {"sample_threshold", "4000"},
    {"sample_threshold", "16000"},
    {"bins", "8"},
    {"bins", "32"},
};

// The ablation has many methods, so it takes the most rays that are not above this.
constexpr uint32_t kMostAblationSide = 1024;

Raster AblationRaster(const std::vector<Raster>& rasters) {
  Raster chosen = rasters.front();
  for (const Raster& raster : rasters) {
    if (raster.rays_a_side() <= kMostAblationSide) chosen = raster;
  }
  return chosen;
}

void Set(Settings& settings, const std::string& name, const std::string& value) {
  try {
    SetByName(settings, name, value);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

Settings ParseSettings(const std::vector<std::string>& assignments) {
  Settings settings;
  settings.budget = 0;  // the published methods keep nothing between calls
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos) {
      throw UsageError("--set takes NAME=VALUE, not \"" + assignment + "\"");
    }
    const std::string name = assignment.substr(0, equals);
    if (name == "algorithm") throw UsageError("--set algorithm: use --algorithm");
    Set(settings, name, assignment.substr(equals + 1));
  }
  return settings;
}

std::vector<Method> ParseAlgorithms(const Settings& settings,
                                    const std::vector<std::string>& names) {
  std::vector<Method> methods;
  for (const std::string& name : names) {
    methods.push_back({name, settings});
    Set(methods.back().settings, "algorithm", name);
  }
  return methods;
}

std::vector<Method> MakeAblation(const Settings& settings) {
  std::vector<Method> methods = {{"the default", settings}};
  for (const Change& change : kAblation) {
    methods.push_back({std::string(change.name) + "=" + change.value, settings});
    Set(methods.back().settings, change.name, change.value);
  }
  return methods;
}

const FrameKind* ParseKind(const std::string& name) {
  std::string legal;
  for (const FrameKind& kind : FrameKinds()) {
    if (kind.name == name) return &kind;
    legal += std::string(" ") + kind.name;
  }
  throw UsageError("--kind: there is no \"" + name + "\"; the kinds are" + legal);
}

}  // namespace

std::optional<MethodOptions> ParseMethodOptions(int argc, char** argv) {
  MethodOptions options;
  std::vector<std::string> scenes, kinds, assignments;
  std::vector<std::string> algorithms = {"nabata2013", "afra2012", "mora2011"};
  std::vector<uint32_t> sides;
  std::string folder = DACRT_SCENES_DIR;
  bool is_short = false, is_full = false, has_ablation = false;

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  CLI::Option* const short_flag =
      app.add_flag("--short", is_short, "The small hall, 256^2 and 512^2 rays: about a minute");
  app.add_flag("--full", is_full, "All scenes, 512^2 to 4096^2 rays: hours")->excludes(short_flag);
  app.add_option("--scene", scenes, "Scenes")->type_name("NAME|FILE");
  app.add_option("--scenes-dir", folder, "Folder of the PLY scenes")
      ->envname("DACRT_SCENES_DIR")
      ->type_name("DIR");
  app.add_option("--kind", kinds, "Frames: point, area, ambient, path, path-dof")
      ->type_name("KIND");
  app.add_option("--rays", sides, "N x N rays a pass: pixels up to 512 x 512, then samples a pixel")
      ->type_name("N");
  app.add_option("--algorithm", algorithms, "Algorithms, the one to compare with first")
      ->capture_default_str()
      ->type_name("NAME");
  app.add_option("--repeat", options.repeat, "Runs, of which the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--set", assignments, "Settings of all algorithms, as in bins=8")
      ->type_name("NAME=VALUE");
  app.add_flag("--ablation", has_ablation,
               "Also the default against itself with one setting changed");
  app.add_option("--json", options.json, "Write all figures")->type_name("FILE");
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  const Extent extent = is_full ? FullExtent() : is_short ? ShortExtent() : StandardExtent();
  for (const std::string& name : scenes.empty() ? extent.scenes : scenes) {
    const SceneSource source(name, folder);
    if (!scenes.empty() || source.IsPresent()) options.scenes.push_back(source);
  }
  for (const std::string& name : kinds) options.kinds.push_back(ParseKind(name));
  if (kinds.empty()) {
    for (const FrameKind& kind : FrameKinds()) options.kinds.push_back(&kind);
  }
  if (sides.empty()) sides = extent.sides;
  for (const uint32_t side : std::set(sides.begin(), sides.end())) {
    options.rasters.emplace_back(side);
  }
  const Settings settings = ParseSettings(assignments);
  options.algorithms = ParseAlgorithms(settings, algorithms);
  if (has_ablation) options.ablation = MakeAblation(settings);
  options.ablation_raster = AblationRaster(options.rasters);
  return options;
}

}  // namespace dacrt::bench
