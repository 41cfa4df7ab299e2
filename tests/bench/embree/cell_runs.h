// Going through the cells of a matrix.
#pragma once

#include <algorithm>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "errors.h"

namespace dacrt::bench {

/// Calls `work` with each run of cells of which any two next to each other are alike.
template <class Cell, class AreAlike, class Work>
void ForEachRun(std::span<const Cell> cells, const AreAlike& are_alike, const Work& work) {
  while (!cells.empty()) {
    const auto last = std::ranges::adjacent_find(cells, std::not_fn(are_alike));
    const std::size_t count = last == cells.end() ? cells.size() : last - cells.begin() + 1;
    work(cells.first(count));
    cells = cells.subspan(count);
  }
}

/// Adds to `results` the cells that an earlier run has written to the JSON file, if there was one.
/// Throws UsageError if it is another file.
template <class Results>
void Resume(const std::string& path, Results& results) {
  std::ifstream file(path);
  if (!file) return;
  try {
    AddCells(nlohmann::ordered_json::parse(file), results);
  } catch (const nlohmann::json::exception&) {
    throw UsageError(path + " is not a result that can be resumed");
  }
}

}  // namespace dacrt::bench
