// What a conformance run counted, and examples of what it found.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compare.h"

namespace dacrt::tests {

/// Counts of one kind of rays in one scene.
struct Tally {
  uint64_t rays = 0;         ///< rays traced by both libraries
  uint64_t comparisons = 0;  ///< one for each of these and each device of the real library
  uint64_t audits = 0;       ///< answers of the drop-in that were checked by the reference alone
  std::array<uint64_t, kRelationCount> relations{};
  /// For each relation, how often exact arithmetic sides with whom.
  std::array<std::array<uint64_t, kSideCount>, kRelationCount> sides{};

  uint64_t Count(Relation relation) const { return relations[static_cast<int>(relation)]; }
  Tally& operator+=(const Tally& other);
};

class Report {
 public:
  struct Example {
    Relation relation;
    std::string text;
  };

  Tally& At(const std::string& scene, const std::string& kind) { return tallies_[{scene, kind}]; }

  /// Keeps the first few examples of a relation in each scene, and more of what is unexplained.
  bool WantsExample(const std::string& scene, Relation relation) const;
  void AddExample(const std::string& scene, Relation relation, std::string text);

  Tally Total() const;

  /// By scene and kind.
  const std::map<std::pair<std::string, std::string>, Tally>& tallies() const { return tallies_; }
  const std::vector<Example>& examples() const { return examples_; }

  void PrintTable(std::ostream& out) const;
  void PrintExamples(std::ostream& out) const;
  void PrintJson(std::ostream& out) const;

 private:
  std::map<std::pair<std::string, std::string>, Tally> tallies_;
  std::map<std::pair<std::string, Relation>, uint32_t> example_counts_;
  std::vector<Example> examples_;
};

}  // namespace dacrt::tests
