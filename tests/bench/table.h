// Tables on the terminal, columns as wide as their widest cell, and in Markdown.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace dacrt::bench {

class Table {
 public:
  /// The first `left` columns hold words and are aligned left, the others hold numbers.
  Table(std::vector<std::string> header, std::size_t left);

  /// `row` has as many cells as the header.
  void Add(std::vector<std::string> row);

  void Print(std::ostream& out) const;
  void PrintMarkdown(std::ostream& out) const;

 private:
  std::vector<std::vector<std::string>> rows_;  ///< the header first
  std::size_t left_;
};

}  // namespace dacrt::bench
