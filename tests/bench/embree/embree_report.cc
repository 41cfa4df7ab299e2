#include "embree_report.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "batch_size.h"
#include "format.h"
#include "goals.h"
#include "isa.h"
#include "sections.h"
#include "table.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

constexpr double kMillion = 1e6;

std::string Milliseconds(double seconds) { return Significant(seconds * 1e3); }

std::string Megabytes(std::size_t bytes) { return Significant(bytes / kMillion); }

Section Goals(const EmbreeResults& results) {
  return {"Goals", "Ratios are Embree's time over dacrt's: above 1 dacrt is faster.",
          GoalsTable(JudgeGoals(results))};
}

// The figures that change where Embree's scenes are of high quality.
Section GoalsWithHighQuality(const EmbreeResults& results) {
  EmbreeResults high = results;
  for (CellResult& cell : high.cells) cell = cell.WithHighQuality();
  const std::vector<Goal> as_built = JudgeGoals(results), with_high = JudgeGoals(high);
  std::vector<Goal> goals;
  for (std::size_t i = 0; i < with_high.size(); ++i) {
    if (with_high[i].measured != as_built[i].measured) goals.push_back(with_high[i]);
  }
  return {"Goals, with Embree's scenes of high quality",
          "The same run, where still scenes were built with RTC_BUILD_QUALITY_HIGH as well, which "
          "splits triangles, and rays were quicker in them.",
          GoalsTable(goals)};
}

// The ratios of these cells: one shot, where it was measured, and steady.
std::string Means(const std::vector<const CellResult*>& cells) {
  std::vector<double> one_shot, steady;
  for (const CellResult* const result : cells) {
    if (result->HasOneShot()) one_shot.push_back(result->OneShotRatio());
    steady.push_back(result->SteadyRatio());
  }
  if (steady.empty()) return "";
  const std::string mean = Significant(GeometricMean(steady));
  return one_shot.empty() ? mean : Significant(GeometricMean(one_shot)) + " / " + mean;
}

// Sizes across, and a row for each name that `row_of` has for the cells, in the order in which they
// come; cells for which it has none are left out.
template <class RowOf>
Table SummaryTable(const EmbreeResults& results, const char* title, const RowOf& row_of) {
  std::vector<std::string> rows;
  std::map<std::pair<std::string, std::string>, std::vector<const CellResult*>> cells;
  for (const CellResult& result : results.cells) {
    const std::string row = row_of(result.cell);
    if (row.empty()) continue;
    if (std::ranges::find(rows, row) == rows.end()) rows.push_back(row);
    cells[{row, result.cell.size}].push_back(&result);
  }
  std::vector<std::string> header = {title};
  for (const BatchSize& size : BatchSizes()) header.push_back(size.name);
  constexpr std::size_t kLeft = 1;
  Table table(header, kLeft);
  for (const std::string& row : rows) {
    std::vector<std::string> line = {row};
    for (const BatchSize& size : BatchSizes()) line.push_back(Means(cells[{row, size.name}]));
    table.Add(std::move(line));
  }
  return table;
}

Section ByKind(const EmbreeResults& results) {
  return {"By kind of rays",
          "One shot / steady, or steady alone, against the rays a call: geometric means over the "
          "scenes. Triangles, the best instruction set.",
          SummaryTable(results, "rays", [](const Cell& cell) -> std::string {
            if (cell.geometry != "triangles" || cell.isa != IsasHere().front()) return "";
            return cell.kind + ", " + ThreadsText(cell.threads);
          })};
}

Section ByScene(const EmbreeResults& results) {
  return {"By scene", "The same, over the kinds of rays.",
          SummaryTable(results, "scene", [](const Cell& cell) -> std::string {
            if (cell.geometry != "triangles" || cell.isa != IsasHere().front()) return "";
            return cell.scene + ", " + ThreadsText(cell.threads);
          })};
}

Section ByGeometry(const EmbreeResults& results) {
  return {"By kind of geometry", "Steady, over the scenes and the kinds of rays.",
          SummaryTable(results, "geometry", [](const Cell& cell) -> std::string {
            if (cell.geometry == "triangles") return "";
            return cell.geometry + ", " + ThreadsText(cell.threads);
          })};
}

Section ByIsa(const EmbreeResults& results) {
  return {"By instruction set", "Both libraries limited to it. Triangles, one thread.",
          SummaryTable(results, "instruction set", [](const Cell& cell) -> std::string {
            return cell.geometry != "triangles" || cell.threads != 1 ? "" : cell.isa;
          })};
}

Section Cells(const EmbreeResults& results) {
  constexpr std::size_t kLeft = 5;
  Table table({"scene", "geometry", "isa", "rays", "size", "number", "threads", "Embree commit",
               "first", "steady", "dacrt commit", "first", "steady", "one shot x", "steady x",
               "Embree's best, one shot", "steady"},
              kLeft);
  for (const CellResult& result : results.cells) {
    std::vector<std::string> row = {result.cell.scene,
                                    result.cell.geometry,
                                    result.cell.isa,
                                    result.cell.kind,
                                    result.cell.size,
                                    Grouped(result.rays),
                                    std::to_string(result.cell.threads)};
    for (const Times* const times : {&result.embree, &result.dacrt}) {
      row.push_back(result.HasOneShot() ? Milliseconds(Median(times->commit)) : "");
      row.push_back(result.HasOneShot() ? Milliseconds(Median(times->first)) : "");
      row.push_back(Significant(result.rays / times->Steady() / kMillion));
    }
    row.push_back(result.HasOneShot() ? Significant(result.OneShotRatio()) : "");
    row.push_back(Significant(result.SteadyRatio()));
    row.push_back(result.embree_one_shot);
    row.push_back(result.embree_steady);
    table.Add(std::move(row));
  }
  return {
      "Cells",
      "One shot: commit of a scene not seen before and the first call, in milliseconds. "
      "Steady: calls on a still scene that has been called for a while, in million rays a second.",
      std::move(table)};
}

Section Memory(const EmbreeResults& results) {
  constexpr std::size_t kLeft = 3;
  Table table(
      {"scene", "geometry", "size", "triangles", "threads", "Embree kept", "announced", "peak",
       "announced", "dacrt kept", "announced", "peak", "announced", "left", "peak ratio"},
      kLeft);
  for (const MemoryResult& result : results.memory) {
    std::vector<std::string> row = {result.cell.scene, result.cell.geometry, result.cell.size,
                                    Grouped(result.triangles), std::to_string(result.cell.threads)};
    for (const MemoryUse& use : {result.embree, result.dacrt}) {
      for (const std::size_t bytes :
           {use.kept_resident, use.kept_announced, use.peak_resident, use.peak_announced}) {
        row.push_back(Megabytes(bytes));
      }
    }
    row.push_back(Megabytes(result.dacrt.left_resident));
    row.push_back(
        Significant(static_cast<double>(result.dacrt.peak_resident) / result.embree.peak_resident));
    table.Add(std::move(row));
  }
  return {
      "Memory",
      "Megabytes beyond the mesh and the rays, diffuse rays: kept after a call and at the peak, "
      "of the process, and as announced to the memory monitor. Left: when dacrt's scene has been "
      "released, which are the workspaces. Peak ratio: dacrt's over "
      "Embree's.",
      std::move(table)};
}

std::vector<Section> Sections(const EmbreeResults& results) {
  std::vector<Section> sections;
  sections.push_back(Goals(results));
  sections.push_back(GoalsWithHighQuality(results));
  sections.push_back(ByKind(results));
  sections.push_back(ByScene(results));
  sections.push_back(ByGeometry(results));
  sections.push_back(ByIsa(results));
  sections.push_back(Cells(results));
  sections.push_back(Memory(results));
  return sections;
}

Conditions ConditionsOf(const EmbreeResults& results) {
  return {"dacrt beside Embree", results.command, results.processor, results.repeat};
}

}  // namespace

void PrintText(const EmbreeResults& results, std::ostream& out) {
  PrintSections(ConditionsOf(results), Sections(results), out);
}

void PrintMarkdown(const EmbreeResults& results, std::ostream& out) {
  PrintSectionsMarkdown(ConditionsOf(results), Sections(results), out);
}

}  // namespace dacrt::bench
