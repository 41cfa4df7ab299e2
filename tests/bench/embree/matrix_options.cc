#include "matrix_options.h"

#include <CLI/CLI.hpp>

namespace dacrt::bench {

void AddMatrixOptions(CLI::App& app, MatrixOptions& options, const std::string& repeated) {
  app.add_flag("--full", options.is_full, "Everything: hours instead of ten minutes");
  app.add_option("--scene", options.scenes, "Scenes")->type_name("NAME|FILE");
  app.add_option("--scenes-dir", options.folder, "Folder of the PLY scenes")
      ->envname("DACRT_SCENES_DIR")
      ->type_name("DIR");
  AddThreadsOption(app, options.threads);
  app.add_option("--repeat", options.repeat,
                 repeated + ", of which the median counts; short ones more")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  AddOutputOptions(app, options.outputs);
}

}  // namespace dacrt::bench
