// Where a benchmark that goes through a matrix of cells writes what it has found.
#pragma once

#include <sstream>
#include <string>

#include "command_line.h"
#include "output_file.h"

namespace dacrt::bench {

struct Outputs {
  std::string json, markdown;  ///< empty: nowhere
  bool resume = false;
};

/// --json, --markdown, --resume.
void AddOutputOptions(CLI::App& app, Outputs& outputs);

/// Writes results, which have ToJson and PrintMarkdown. Throws OutputError (errors.h).
template <class Results>
void Save(const Outputs& outputs, const Results& results) {
  if (!outputs.json.empty()) WriteFile(outputs.json, JsonText(ToJson(results)));
  if (!outputs.markdown.empty()) {
    std::ostringstream text;
    PrintMarkdown(results, text);
    WriteFile(outputs.markdown, text.str());
  }
}

}  // namespace dacrt::bench
