#include "sections.h"

#include <ostream>

namespace dacrt::bench {
namespace {

std::string Text(const Conditions& conditions) {
  return conditions.processor + ", median of " + std::to_string(conditions.repeat) +
         " rounds or more";
}

}  // namespace

void PrintSections(const Conditions& conditions, const std::vector<Section>& sections,
                   std::ostream& out) {
  out << Text(conditions) << '\n';
  for (const Section& section : sections) {
    out << '\n' << section.title << "\n\n" << section.note << '\n';
    section.table.Print(out);
  }
}

void PrintSectionsMarkdown(const Conditions& conditions, const std::vector<Section>& sections,
                           std::ostream& out) {
  out << "# " << conditions.title << "\n\n"
      << Text(conditions) << ":\n\n```sh\n"
      << conditions.command << "\n```\n";
  for (const Section& section : sections) {
    out << "\n## " << section.title << "\n\n" << section.note << "\n\n";
    section.table.PrintMarkdown(out);
  }
}

}  // namespace dacrt::bench
