#include "moving_options.h"

#include <CLI/CLI.hpp>

#include "command_line.h"
#include "moving_cells.h"
#include "moving_content.h"

namespace dacrt::bench {
namespace {

constexpr char kDescription[] =
    R"(Measures dacrt's drop-in beside Embree itself on scenes that change: frames of a change, a commit
and one stream of rays, in one process, in turn, on the same scenes and rays. Embree is at its best:
the fastest of medium quality, of geometries of low quality in a dynamic scene of low quality, and,
where only vertices move, of geometries of refit quality; of AVX2 and AVX-512; of coherent and
incoherent streams and single rays, called from as many threads as there may be.)";

constexpr char kFooter[] = R"(
Changes: wave, all vertices of a mesh move; one-of-1000, one mesh of a thousand moves; instances, a
thousand of them turn; growing, a mesh has more triangles in another index buffer; replaced, one mesh
goes and another comes.

A scene is hall-75k, hall-260k, hall-1m, hall-5m or another hall-N (generated), sibenik, sponza,
country_kitchen, terrain_white_mountains, dragon and others (PLY files in the folder of scenes), or
any mesh that Assimp reads. Scenes that nobody named and that are not there are left out.

A frame's time is that of the calls that tell of the change, of the commit and of the stream. Ratios
are Embree's time over dacrt's.

Exit codes: 0 measured, 1 a library or memory cannot be had, 2 bad command line, 3 measured, but a
scene could not be read, 4 the libraries found different hits, 5 an output cannot be written.)";

}  // namespace

std::optional<MovingOptions> ParseMovingOptions(int argc, char** argv) {
  MovingOptions options;
  options.folder = DACRT_SCENES_DIR;
  MovingBlock named;
  std::vector<int> threads = OneAndAllThreads();
  bool is_full = false;

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  app.add_flag("--full", is_full, "Everything: hours instead of ten minutes");
  app.add_option("--scene", named.scenes, "Scenes")->type_name("NAME|FILE");
  app.add_option("--scenes-dir", options.folder, "Folder of the PLY scenes")
      ->envname("DACRT_SCENES_DIR")
      ->type_name("DIR");
  AddNamesOption(app, "--change", named.changes, NamesOf(ChangeKinds()), "Kinds of change");
  AddNamesOption(app, "--kind", named.kinds, MovingRayKinds(), "Kinds of rays");
  AddNamesOption(app, "--rays", named.sizes, NamesOf(FrameSizes()), "Rays a frame");
  AddThreadsOption(app, threads);
  app.add_option("--repeat", options.repeat, "Frames, of which the median counts; short ones more")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  AddOutputOptions(app, options.outputs);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  const std::vector<MovingBlock> blocks = is_full ? FullMovingBlocks(options.folder, threads)
                                                  : ShortMovingBlocks(options.folder, threads);
  // What is named is measured in all combinations, with the rest as in the first block.
  MovingBlock all = blocks.front();
  all.threads = threads;
  bool is_named = false;
  for (const auto list :
       {&MovingBlock::scenes, &MovingBlock::changes, &MovingBlock::kinds, &MovingBlock::sizes}) {
    if ((named.*list).empty()) continue;
    all.*list = named.*list;
    is_named = true;
  }
  options.cells = CellsOf(is_named ? std::vector{all} : blocks);
  return options;
}

}  // namespace dacrt::bench
