// Going through the cells of a matrix.
#pragma once

#include <algorithm>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench_scene.h"
#include "errors.h"
#include "outputs.h"
#include "progress.h"

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

/// Drops the cells that the results have already.
template <class Cell, class Results>
void DropMeasured(const Results& results, std::vector<Cell>& cells) {
  std::erase_if(cells, [&](const Cell& cell) {
    return std::ranges::any_of(results.cells,
                               [&](const auto& result) { return result.cell == cell; });
  });
}

/// Loads one scene after the other, and calls `measure` with it and with each run of its cells that
/// are measured together. Goes on without scenes that cannot be read: returns whether all could.
template <class Cell, class Measure>
bool MeasureByScene(std::span<const Cell> cells, const std::string& folder, Progress& progress,
                    const Measure& measure) {
  const auto are_of_one_scene = [](const Cell& a, const Cell& b) { return a.scene == b.scene; };
  const auto are_together = [](const Cell& a, const Cell& b) { return AreMeasuredTogether(a, b); };
  bool is_complete = true;
  ForEachRun(cells, are_of_one_scene, [&](std::span<const Cell> of_scene) {
    progress.Show(of_scene.front().scene + ": loading");
    try {
      const BenchScene scene = SceneSource(of_scene.front().scene, folder).LoadForEmbree();
      ForEachRun(of_scene, are_together,
                 [&](std::span<const Cell> together) { measure(scene, together); });
    } catch (const UnreadableScene& error) {
      is_complete = false;
      progress.Say(error.what());
      progress.Skip(of_scene.size());
    }
  });
  return is_complete;
}

/// A benchmark's whole run: measures the cells of `options` but those that the results have from an
/// earlier one, as `measure` does with a scene, cells that are measured together, and the progress;
/// saves them, and prints them. Returns the exit code.
template <class Options, class Results, class Measure>
int MeasureMatrix(const Options& options, Results& results, const Measure& measure) {
  auto cells = options.cells;
  if (options.outputs.resume) {
    Resume(options.outputs.json, results);
    DropMeasured(results, cells);
  }
  Save(options.outputs, results);  // an output that cannot be written shows before measuring
  Progress progress(cells.size());
  using Cell = typename decltype(cells)::value_type;
  const bool is_complete =
      MeasureByScene(std::span<const Cell>(cells), options.folder, progress,
                     [&](const BenchScene& scene, std::span<const Cell> together) {
                       measure(scene, together, progress);
                     });
  PrintText(results, std::cout);
  return is_complete ? kSuccess : kUnreadableScene;
}

}  // namespace dacrt::bench
