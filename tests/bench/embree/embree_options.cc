#include "embree_options.h"

#include <algorithm>
#include <set>
#include <thread>

#include "batch_size.h"
#include "bench_scene.h"
#include "command_line.h"
#include "isa.h"
#include "ray_kind.h"

namespace dacrt::bench {
namespace {

constexpr char kDescription[] =
    R"(Measures dacrt's drop-in beside Embree itself, in one process, in turn, on the same meshes
and rays: scenes x kinds of rays x rays a call x threads. Embree is at its best: the fastest of AVX2
and AVX-512, of low and medium build quality, of coherent and incoherent streams and single rays,
called from as many threads as there may be. The drop-in is called from one.)";

constexpr char kFooter[] = R"(
A scene is one of hall-75k, hall-260k, hall-1m, hall-5m (generated), sibenik, sponza,
country_kitchen, terrain_white_mountains, dragon (PLY files in the folder of scenes), or any mesh
that Assimp reads. Scenes that nobody named and that are not there are left out.

One shot: commit of a scene not seen before, and the first call. Steady: a later call on a still
scene; of 64 and 4K rays, the mean of calls with consecutive slices of a picture. Ratios are
Embree's time over dacrt's.

Exit codes: 0 measured, 1 a library or memory cannot be had, 2 bad command line, 3 measured, but a
scene could not be read, 4 the libraries found different hits, 5 an output cannot be written.)";

// A part of the matrix without the threads.
struct Block {
  std::vector<std::string> scenes;
  std::vector<std::string> kinds;
  std::vector<std::string> sizes;

  bool Has(const std::string& scene, const std::string& kind, const std::string& size) const {
    const auto has = [](const auto& list, const auto& name) {
      return std::ranges::find(list, name) != list.end();
    };
    return has(scenes, scene) && has(kinds, kind) && has(sizes, size);
  }
};

std::vector<std::string> AllKinds() {
  std::vector<std::string> names;
  for (const RayKind& kind : RayKinds()) names.push_back(kind.name);
  return names;
}

std::vector<std::string> AllSizes() {
  std::vector<std::string> names;
  for (const BatchSize& size : BatchSizes()) names.push_back(size.name);
  return names;
}

std::vector<std::string> PresentScenes(const std::string& folder) {
  std::vector<std::string> names = SceneNames();
  std::erase_if(names,
                [&](const std::string& name) { return !SceneSource(name, folder).IsPresent(); });
  return names;
}

Block ShortBlock() {
  return {{"hall-75k", "hall-260k", "hall-1m"}, AllKinds(), {"64", "4K", "64K", "1M"}};
}

// What the short setting has of the large cells, so that each goal has a figure.
const Block kLargeMesh = {{"hall-5m"}, {"shadow", "diffuse"}, {"64K", "1M"}};
const Block kLargeBatch = {{"hall-260k"}, {"diffuse"}, {"16M"}};

std::vector<Cell> CellsOf(const std::vector<Block>& blocks, const std::set<int>& threads) {
  std::vector<std::string> scenes;
  for (const Block& block : blocks) {
    for (const std::string& scene : block.scenes) {
      if (std::ranges::find(scenes, scene) == scenes.end()) scenes.push_back(scene);
    }
  }
  std::vector<Cell> cells;
  for (const std::string& scene : scenes) {
    for (const int count : threads) {
      for (const BatchSize& size : BatchSizes()) {
        for (const RayKind& kind : RayKinds()) {
          const bool is_meant = std::ranges::any_of(
              blocks, [&](const Block& block) { return block.Has(scene, kind.name, size.name); });
          if (is_meant)
            cells.push_back({scene, "triangles", IsasHere().front(), kind.name, size.name, count});
        }
      }
    }
  }
  return cells;
}

}  // namespace

std::optional<EmbreeOptions> ParseEmbreeOptions(int argc, char** argv) {
  EmbreeOptions options;
  options.folder = DACRT_SCENES_DIR;
  Block named;
  std::vector<int> threads = {1,
                              std::max(1, static_cast<int>(std::thread::hardware_concurrency()))};
  bool is_full = false;

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.add_flag("--full", is_full, "All scenes and all sizes: hours instead of ten minutes");
  app.add_option("--scene", named.scenes, "Scenes")->type_name("NAME|FILE");
  app.add_option("--scenes-dir", options.folder, "Folder of the PLY scenes")
      ->envname("DACRT_SCENES_DIR")
      ->type_name("DIR");
  app.add_option("--kind", named.kinds, "Kinds of rays")
      ->check(CLI::IsMember(AllKinds()))
      ->type_name("KIND");
  app.add_option("--rays", named.sizes, "Rays a call")
      ->check(CLI::IsMember(AllSizes()))
      ->type_name("SIZE");
  app.add_option("--threads", threads, "Numbers of threads, by default one and all")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  app.add_option("--repeat", options.repeat, "Rounds, of which the median counts; short ones more")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  CLI::Option* const json =
      app.add_option("--json", options.json, "Write all figures")->type_name("FILE");
  app.add_option("--markdown", options.markdown, "Write the tables")->type_name("FILE");
  app.add_option("--plots", options.plots, "Write plots as SVG")->type_name("DIR");
  app.add_flag("--resume", options.resume, "Keep the cells that the JSON file has already")
      ->needs(json);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  const bool is_named = !named.scenes.empty() || !named.kinds.empty() || !named.sizes.empty();
  const Block usual =
      is_full ? Block{PresentScenes(options.folder), AllKinds(), AllSizes()} : ShortBlock();
  if (named.scenes.empty()) named.scenes = usual.scenes;
  if (named.kinds.empty()) named.kinds = usual.kinds;
  if (named.sizes.empty()) named.sizes = usual.sizes;
  std::vector<Block> blocks = {named};
  if (!is_full && !is_named) blocks.insert(blocks.end(), {kLargeMesh, kLargeBatch});
  options.cells = CellsOf(blocks, {threads.begin(), threads.end()});
  return options;
}

}  // namespace dacrt::bench
