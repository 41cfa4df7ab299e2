#include "outputs.h"

#include <filesystem>

namespace dacrt::bench {

void AddOutputOptions(CLI::App& app, Outputs& outputs) {
  CLI::Option* const json =
      app.add_option("--json", outputs.json, "Write all figures")->type_name("FILE");
  app.add_option("--markdown", outputs.markdown, "Write the tables")->type_name("FILE");
  app.add_option("--plots", outputs.plots, "Write plots as SVG")->type_name("DIR");
  app.add_flag("--resume", outputs.resume, "Keep the cells that the JSON file has already")
      ->needs(json);
}

std::string PictureLinks(const std::string& page, const std::string& folder,
                         const std::vector<std::string>& files) {
  if (files.empty()) return "";
  const auto from = std::filesystem::absolute(page).parent_path();
  const auto to = std::filesystem::absolute(folder).lexically_relative(from);
  std::string links = "\n## Plots\n\n";
  for (const std::string& file : files) {
    links +=
        "![" + std::filesystem::path(file).stem().string() + "](" + (to / file).string() + ")\n";
  }
  return links;
}

}  // namespace dacrt::bench
