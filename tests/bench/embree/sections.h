// A page of results: tables with titles, on the terminal and in Markdown.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "table.h"

namespace dacrt::bench {

struct Section {
  std::string title;
  std::string note;
  Table table;
};

/// What the results are, and were measured with.
struct Conditions {
  std::string title;
  std::string command;
  std::string processor;
  int repeat;
};

void PrintSections(const Conditions& conditions, const std::vector<Section>& sections,
                   std::ostream& out);

/// The same as a page, with the command that made it.
void PrintSectionsMarkdown(const Conditions& conditions, const std::vector<Section>& sections,
                           std::ostream& out);

}  // namespace dacrt::bench
