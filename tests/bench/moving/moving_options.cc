#include "moving_options.h"

#include <CLI/CLI.hpp>

#include "matrix_options.h"
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
  MatrixOptions matrix;
  matrix.repeat = 5;
  MovingBlock named;

  CLI::App app(kDescription);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  AddMatrixOptions(app, matrix, "Frames");
  AddNamesOption(app, "--change", named.changes, NamesOf(ChangeKinds()), "Kinds of change");
  AddNamesOption(app, "--kind", named.kinds, MovingRayKinds(), "Kinds of rays");
  AddNamesOption(app, "--rays", named.sizes, NamesOf(FrameSizes()), "Rays a frame");
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  named.scenes = matrix.scenes;
  named.threads = matrix.threads;
  const std::vector<MovingBlock> blocks = matrix.is_full
                                              ? FullMovingBlocks(matrix.folder, matrix.threads)
                                              : ShortMovingBlocks(matrix.folder, matrix.threads);
  return MovingOptions{
      .cells = CellsOf(NamedOr(blocks, named, &MovingBlock::scenes, &MovingBlock::changes,
                               &MovingBlock::kinds, &MovingBlock::sizes)),
      .folder = matrix.folder,
      .repeat = matrix.repeat,
      .outputs = matrix.outputs};
}

}  // namespace dacrt::bench
