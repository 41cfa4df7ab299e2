#include "options.h"

#include <CLI/CLI.hpp>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>

#include "batch_size.h"
#include "bench_scene.h"
#include "command_line.h"
#include "errors.h"
#include "exit_codes.h"
#include "isa.h"
#include "libraries.h"
#include "ray_kind.h"

namespace dacrt::compare {
namespace {

namespace fs = std::filesystem;

constexpr char kDescription[] =
    R"(Whether to switch: runs your own mesh or program on Embree 3 and on dacrt, on this machine, and says
where dacrt gains, where it loses, and what to set.

  dacrt-compare [OPTIONS] MESH
  dacrt-compare [OPTIONS] PROGRAM [ARGUMENT]...)";

constexpr char kFooter[] = R"(
  dacrt-compare scan.ply
  dacrt-compare --rays 1K 1M --kind diffuse --json figures.json scan.ply
  dacrt-compare viewer_stream -c cornell_box.ecs --size 512 512 -o picture.ppm

A mesh is an OBJ, PLY, glTF or STL file, or a generated hall: hall-260k, hall-2m. It is committed and
traced in this process by both libraries in turn; Embree is at its best for each line: of AVX2 and
AVX-512, of its builders, of streams and single rays.

A program is run unchanged on both libraries, its output discarded. Its calls are counted, and the time
in them, on all threads together. It must end by itself; interactive ones are ended by hand.

Exit codes: 0 compared, 2 bad command line, 3 mesh cannot be read, 4 the libraries find different hits,
5 the JSON file cannot be written, 6 the program cannot be started or compared, 7 it runs with Embree only, 1 anything else.)";

bool IsMeshFile(const std::string& name) {
  std::string extension = fs::path(name).extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr const char* kExtensions[] = {".obj", ".ply", ".gltf", ".glb", ".stl"};
  return std::ranges::find(kExtensions, extension) != std::end(kExtensions);
}

bool IsExecutableFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

bool IsProgram(const std::string& name) {
  if (name.find('/') != std::string::npos) return IsExecutableFile(name);
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (IsExecutableFile(fs::path(folder) / name)) return true;
  }
  return false;
}

void TakeTarget(std::vector<std::string> words, const CLI::App& app, Options& options) {
  if (!words.empty() && words.front() == "--") words.erase(words.begin());
  if (words.empty()) throw bench::UsageError("a mesh or a program is needed (see --help)");
  const std::string& target = words.front();
  if (target.starts_with("-")) {
    std::string legal;
    for (const CLI::Option* option : app.get_options()) legal += " " + option->get_name();
    throw bench::UsageError(target + ": there is no such option; there are" + legal);
  }
  if (IsMeshFile(target) || bench::SceneSource(target, "").IsGenerated()) {
    if (words.size() > 1) {
      throw bench::UsageError(words[1] + ": a mesh takes no arguments; options stand before it");
    }
    if (IsMeshFile(target) && !fs::exists(target)) {
      throw bench::UnreadableScene(target + ": there is no such file");
    }
    options.mesh = target;
  } else if (IsProgram(target)) {
    options.command = std::move(words);
  } else {
    throw ProgramError(target +
                       ": this is neither a mesh (.obj, .ply, .gltf, .glb, .stl or hall-N) nor a "
                       "program that can be started");
  }
}

}  // namespace

std::optional<Options> ParseOptions(int argc, char** argv) {
  Options options;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  options.isa = bench::IsasHere().front();
  options.kinds = {"primary", "shadow", "ambient", "diffuse"};
  options.sizes = {"1", "16", "1K", "64K", "1M"};

  CLI::App app(kDescription, "dacrt-compare");
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.prefix_command();
  app.add_option("--embree", options.embree, "Embree's library, by default the system's")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  app.add_option("--dacrt", options.drop_in, "dacrt's, by default the one installed with this")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  app.add_option("--config", options.config, "DACRT_CONFIG for dacrt, as in dacrt_budget=0")
      ->type_name("CONFIG");
  app.add_option("--json", options.json, "Also write all figures")->type_name("FILE");
  app.add_option("--repeat", options.repeat, "Rounds, of which the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--threads", options.threads, "Meshes: threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--isa", options.isa, "Meshes: the most that both may use")
      ->check(CLI::IsMember(bench::IsasHere()))
      ->capture_default_str()
      ->type_name("ISA");
  app.add_option("--kind", options.kinds, "Meshes: kinds of rays, before --")
      ->check(CLI::IsMember(bench::NamesOf(bench::RayKinds())))
      ->capture_default_str()
      ->type_name("KIND");
  app.add_option("--rays", options.sizes, "Meshes: rays a call, before --")
      ->check(CLI::IsMember(bench::NamesOf(bench::BatchSizes())))
      ->capture_default_str()
      ->type_name("SIZE");
  if (!bench::ParseCommandLine(app, argc, argv)) return std::nullopt;
  TakeTarget(app.remaining(), app, options);
  // What cannot be written is found before anything is measured.
  if (!options.json.empty() && !std::ofstream(options.json, std::ios::app)) {
    throw bench::OutputError(options.json + ": cannot be written");
  }
  if (options.drop_in.empty()) options.drop_in = FindDropIn();
  options.drop_in = fs::canonical(options.drop_in).string();  // with a slash
  if (!options.embree.empty()) options.embree = fs::canonical(options.embree).string();
  return options;
}

}  // namespace dacrt::compare
