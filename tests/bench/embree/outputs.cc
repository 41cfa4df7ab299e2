#include "outputs.h"

#include <CLI/CLI.hpp>

namespace dacrt::bench {

void AddOutputOptions(CLI::App& app, Outputs& outputs) {
  CLI::Option* const json =
      app.add_option("--json", outputs.json, "Write all figures")->type_name("FILE");
  app.add_option("--markdown", outputs.markdown, "Write the tables")->type_name("FILE");
  app.add_flag("--resume", outputs.resume, "Keep the cells that the JSON file has already")
      ->needs(json);
}

}  // namespace dacrt::bench
