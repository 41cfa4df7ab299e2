#include "report.h"

#include <iomanip>
#include <ostream>

namespace dacrt::tests {
namespace {

constexpr Relation RelationAt(int i) { return static_cast<Relation>(i); }

constexpr int kNameWidth = 42;

/// One line: the rays, and each relation that occurred with its count.
void PrintLine(std::ostream& out, const std::string& name, const Tally& tally) {
  out << std::left << std::setw(kNameWidth) << name << std::right << std::setw(12) << tally.rays
      << " rays " << std::setw(12) << tally.Count(Relation::kIdentical) << " identical";
  for (int i = 1; i < kRelationCount; ++i) {
    if (tally.relations[i]) out << ", " << tally.relations[i] << ' ' << Name(RelationAt(i));
  }
  out << '\n';
}

void PrintJsonTally(std::ostream& out, const Tally& tally) {
  out << "\"rays\": " << tally.rays << ", \"comparisons\": " << tally.comparisons
      << ", \"audits\": " << tally.audits;
  for (int i = 0; i < kRelationCount; ++i) {
    out << ", \"" << Name(RelationAt(i)) << "\": " << tally.relations[i];
  }
}

}  // namespace

Tally& Tally::operator+=(const Tally& other) {
  rays += other.rays;
  comparisons += other.comparisons;
  audits += other.audits;
  for (std::size_t i = 0; i < relations.size(); ++i) relations[i] += other.relations[i];
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t k = 0; k < sides[i].size(); ++k) sides[i][k] += other.sides[i][k];
  }
  return *this;
}

bool Report::WantsExample(const std::string& scene, Relation relation) const {
  const uint32_t wanted = relation == Relation::kUnexplained ? 10 : 1;
  const auto found = example_counts_.find({scene, relation});
  return found == example_counts_.end() || found->second < wanted;
}

void Report::AddExample(const std::string& scene, Relation relation, std::string text) {
  ++example_counts_[{scene, relation}];
  examples_.push_back({relation, std::move(text)});
}

Tally Report::Total() const {
  Tally total;
  for (const auto& [key, tally] : tallies_) total += tally;
  return total;
}

void Report::PrintTable(std::ostream& out) const {
  std::map<std::string, Tally> by_scene, by_kind;
  for (const auto& [key, tally] : tallies_) {
    PrintLine(out, key.first + " / " + key.second, tally);
    by_scene[key.first] += tally;
    by_kind[key.second] += tally;
  }
  out << "\nby scene\n";
  for (const auto& [scene, tally] : by_scene) PrintLine(out, scene, tally);
  out << "\nby kind of rays\n";
  for (const auto& [kind, tally] : by_kind) PrintLine(out, kind, tally);

  const Tally total = Total();
  out << "\nin all\n";
  PrintLine(out, "", total);
  out << total.comparisons << " comparisons, " << total.audits
      << " answers audited by brute force\n\nwhose answer exact arithmetic gives\n";
  for (int i = 2; i < kRelationCount; ++i) {
    if (total.relations[i] == 0 || RelationAt(i) == Relation::kWithheld) continue;
    out << std::left << std::setw(18) << Name(RelationAt(i)) << std::right;
    for (int side = 0; side < kSideCount; ++side) {
      out << std::setw(10) << total.sides[i][side] << ' ' << Name(static_cast<Side>(side));
    }
    out << '\n';
  }
}

void Report::PrintExamples(std::ostream& out) const {
  for (int i = 1; i < kRelationCount; ++i) {
    // One of each kind tells what it means; of what fails, everything that was kept.
    const std::size_t shown = RelationAt(i) == Relation::kUnexplained ? examples_.size() : 2;
    std::size_t count = 0;
    for (const Example& example : examples_) {
      if (example.relation == RelationAt(i) && count++ < shown) out << example.text << '\n';
    }
  }
}

void Report::PrintJson(std::ostream& out) const {
  out << "{\"cells\": [\n";
  const char* separator = "";
  for (const auto& [key, tally] : tallies_) {
    out << separator << "  {\"scene\": \"" << key.first << "\", \"kind\": \"" << key.second
        << "\", ";
    PrintJsonTally(out, tally);
    out << '}';
    separator = ",\n";
  }
  out << "],\n \"total\": {";
  PrintJsonTally(out, Total());
  out << "}}\n";
}

}  // namespace dacrt::tests
