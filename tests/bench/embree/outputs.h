// Where a benchmark that goes through a matrix of cells writes what it has found.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "command_line.h"
#include "output_file.h"

namespace dacrt::bench {

struct Outputs {
  std::string json, markdown, plots;  ///< empty: nowhere
  bool resume = false;
};

/// --json, --markdown, --plots, --resume.
void AddOutputOptions(CLI::App& app, Outputs& outputs);

/// Pictures of the folder, as a part of the page.
std::string PictureLinks(const std::string& page, const std::string& folder,
                         const std::vector<std::string>& files);

/// Writes results, which have ToJson, PrintMarkdown and WritePlots. Throws OutputError (errors.h).
template <class Results>
void Save(const Outputs& outputs, const Results& results) {
  if (!outputs.json.empty()) WriteFile(outputs.json, JsonText(ToJson(results)));
  std::vector<std::string> plots;
  if (!outputs.plots.empty()) {
    MakeFolder(outputs.plots);
    plots = WritePlots(results, outputs.plots);
  }
  if (!outputs.markdown.empty()) {
    std::ostringstream text;
    PrintMarkdown(results, text);
    text << PictureLinks(outputs.markdown, outputs.plots, plots);
    WriteFile(outputs.markdown, text.str());
  }
}

}  // namespace dacrt::bench
