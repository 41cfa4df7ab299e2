#include "table.h"

#include <algorithm>
#include <iomanip>
#include <ostream>
#include <utility>

namespace dacrt::bench {
namespace {

constexpr std::size_t kGap = 2;  // between columns

}  // namespace

Table::Table(std::vector<std::string> header, std::size_t left) : left_(left) {
  rows_.push_back(std::move(header));
}

void Table::Add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

void Table::Print(std::ostream& out) const {
  std::vector<std::size_t> widths(rows_.front().size());
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::size_t total = kGap * (widths.size() - 1);
  for (const std::size_t width : widths) total += width;

  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) out << std::string(kGap, ' ');
      out << (i < left_ ? std::left : std::right) << std::setw(static_cast<int>(widths[i]))
          << row[i];
    }
    out << '\n';
    if (&row == &rows_.front()) out << std::string(total, '-') << '\n';
  }
}

void Table::PrintMarkdown(std::ostream& out) const {
  for (const auto& row : rows_) {
    for (const std::string& cell : row) out << "| " << cell << ' ';
    out << "|\n";
    if (&row != &rows_.front()) continue;
    for (std::size_t i = 0; i < row.size(); ++i) out << (i < left_ ? "|---" : "|---:");
    out << "|\n";
  }
}

}  // namespace dacrt::bench
