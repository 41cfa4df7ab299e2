#include "embree_options.h"

#include <CLI/CLI.hpp>

#include "batch_size.h"
#include "cell_list.h"
#include "command_line.h"
#include "geometry_kind.h"
#include "isa.h"
#include "matrix_options.h"
#include "ray_kind.h"

namespace dacrt::bench {
namespace {

constexpr char kDescription[] =
    R"(Measures dacrt's drop-in beside Embree itself, in one process, in turn, on the same scenes and
rays: scenes x kinds of geometry x instruction sets x kinds of rays x rays a call x threads. Embree
is at its best: the fastest of AVX2 and AVX-512 (limited to what the drop-in is limited to), of
coherent and incoherent streams and single rays, called from as many threads as there may be; where
scenes are committed anew, of medium and low build quality and of low quality in a dynamic scene.)";

constexpr char kFooter[] = R"(
A scene is box-36, hall-75k, hall-260k, hall-1m, hall-5m or another hall-N (generated), sibenik,
sponza, country_kitchen, terrain_white_mountains, dragon and others (PLY files in the folder of
scenes), or any mesh that Assimp reads. Scenes that nobody named and that are not there are left out.

Calls of 1 ray are rtcIntersect1 and rtcOccluded1, of 4, 8 and 16 rays packets: both libraries get
them from as many threads. Calls of more rays are streams, which the drop-in gets from one thread.

One shot: commit of a scene not seen before, and the first call. Steady: a later call on a still
scene, which has been called with such rays for half a second, or a second in the full setting; of
less than 64K rays, the mean of calls with consecutive slices of a picture. Ratios are Embree's time
over dacrt's.

Exit codes: 0 measured, 1 a library or memory cannot be had, 2 bad command line, 3 measured, but a
scene could not be read, 4 the libraries found different hits, 5 an output cannot be written.)";

}  // namespace

std::optional<EmbreeOptions> ParseEmbreeOptions(int argc, char** argv) {
  MatrixOptions matrix;
  Block named;

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  AddMatrixOptions(app, matrix, "Rounds");
  AddNamesOption(app, "--geometry", named.geometries, NamesOf(GeometryKinds()),
                 "Kinds of geometry");
  AddNamesOption(app, "--isa", named.isas, IsasHere(), "Instruction sets that both are limited to");
  AddNamesOption(app, "--kind", named.kinds, NamesOf(RayKinds()), "Kinds of rays");
  AddNamesOption(app, "--rays", named.sizes, NamesOf(BatchSizes()), "Rays a call");
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  EmbreeOptions options;
  options.folder = matrix.folder;
  options.outputs = matrix.outputs;
  options.effort.repeat = matrix.repeat;
  if (!matrix.is_full) {
    // Less than ten minutes.
    options.effort.rounds_seconds = 0.3;
    options.effort.warm_seconds = 0.35;
    options.effort.slices_seconds = 0.1;
    options.effort.sliced_side = 256;
  }
  named.scenes = matrix.scenes;
  named.threads = matrix.threads;
  const std::vector<Block> blocks = matrix.is_full ? FullBlocks(matrix.folder, matrix.threads)
                                                   : ShortBlocks(matrix.folder, matrix.threads);
  options.cells = CellsOf(NamedOr(blocks, named, &Block::scenes, &Block::geometries, &Block::isas,
                                  &Block::kinds, &Block::sizes));
  return options;
}

}  // namespace dacrt::bench
