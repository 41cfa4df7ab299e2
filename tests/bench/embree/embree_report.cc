#include "embree_report.h"

#include <ostream>
#include <set>
#include <utility>

#include "batch_size.h"
#include "format.h"
#include "goals.h"
#include "ray_kind.h"
#include "table.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

constexpr double kMillion = 1e6;

struct Section {
  std::string title;
  std::string note;
  Table table;
};

std::string Number(double value) { return Fixed(value, value < 1 ? 3 : value < 10 ? 2 : 1); }

std::string Milliseconds(double seconds) { return Number(seconds * 1e3); }

std::string Megabytes(std::size_t bytes) { return Number(bytes / kMillion); }

Section Goals(const EmbreeResults& results) {
  constexpr std::size_t kLeft = 2;
  Table table({"figure", "judged by", "cells", "goal", "measured", "", "worst cell"}, kLeft);
  for (const Goal& goal : JudgeGoals(results)) {
    const bool is_least = goal.bound == Goal::Bound::kAtLeast;
    const bool is_worst = goal.judged == Goal::Judged::kWorstCell;
    table.Add({goal.figure, is_worst ? "worst cell" : "geometric mean", Grouped(goal.cells),
               (is_least ? "at least " : "at most ") + Number(goal.goal),
               goal.measured ? Number(*goal.measured) : "",
               !goal.measured ? "not measured"
               : goal.IsMet() ? "met"
                              : "missed",
               goal.worst_cell});
  }
  return {"Goals", "Ratios are Embree's time over dacrt's: above 1 dacrt is faster.",
          std::move(table)};
}

// The two ratios of the cells of a kind, a size and a number of threads, over all scenes.
std::string Means(const std::vector<CellResult>& cells, const char* kind, const char* size,
                  int threads) {
  std::vector<double> one_shot, steady;
  for (const CellResult& result : cells) {
    const Cell& cell = result.cell;
    if (cell.kind != kind || cell.size != size || cell.threads != threads) continue;
    one_shot.push_back(result.OneShotRatio());
    steady.push_back(result.SteadyRatio());
  }
  if (steady.empty()) return "";
  return Number(GeometricMean(one_shot)) + " / " + Number(GeometricMean(steady));
}

Section Summary(const EmbreeResults& results) {
  std::set<int> threads;
  for (const CellResult& result : results.cells) threads.insert(result.cell.threads);
  std::vector<std::string> header = {"rays", "threads"};
  for (const BatchSize& size : BatchSizes()) header.push_back(size.name);
  constexpr std::size_t kLeft = 1;
  Table table(header, kLeft);
  for (const RayKind& kind : RayKinds()) {
    for (const int count : threads) {
      std::vector<std::string> row = {kind.name, std::to_string(count)};
      for (const BatchSize& size : BatchSizes()) {
        row.push_back(Means(results.cells, kind.name, size.name, count));
      }
      table.Add(std::move(row));
    }
  }
  return {"By kind and size", "One shot / steady, geometric means over the scenes.",
          std::move(table)};
}

Section Cells(const EmbreeResults& results) {
  constexpr std::size_t kLeft = 3;
  Table table({"scene", "rays", "size", "number", "threads", "Embree commit", "first", "steady",
               "dacrt commit", "first", "steady", "one shot x", "steady x",
               "Embree's best, one shot", "steady"},
              kLeft);
  for (const CellResult& result : results.cells) {
    const auto rate = [&](const Times& times) {
      return Number(result.rays / times.Steady() / kMillion);
    };
    table.Add({result.cell.scene, result.cell.kind, result.cell.size, Grouped(result.rays),
               std::to_string(result.cell.threads), Milliseconds(Median(result.embree.commit)),
               Milliseconds(Median(result.embree.first)), rate(result.embree),
               Milliseconds(Median(result.dacrt.commit)), Milliseconds(Median(result.dacrt.first)),
               rate(result.dacrt), Number(result.OneShotRatio()), Number(result.SteadyRatio()),
               result.embree_one_shot, result.embree_steady});
  }
  return {"Cells",
          "One shot: commit of a scene not seen before and the first call, in milliseconds. "
          "Steady: later calls on a still scene, in million rays a second.",
          std::move(table)};
}

Section Memory(const EmbreeResults& results) {
  constexpr std::size_t kLeft = 2;
  Table table({"scene", "size", "triangles", "threads", "Embree kept", "announced", "peak",
               "announced", "dacrt kept", "announced", "peak", "announced", "peak ratio"},
              kLeft);
  for (const MemoryResult& result : results.memory) {
    std::vector<std::string> row = {result.cell.scene, result.cell.size, Grouped(result.triangles),
                                    std::to_string(result.cell.threads)};
    for (const MemoryUse& use : {result.embree, result.dacrt}) {
      for (const std::size_t bytes :
           {use.kept_resident, use.kept_announced, use.peak_resident, use.peak_announced}) {
        row.push_back(Megabytes(bytes));
      }
    }
    row.push_back(
        Number(static_cast<double>(result.dacrt.peak_resident) / result.embree.peak_resident));
    table.Add(std::move(row));
  }
  return {
      "Memory",
      "Megabytes beyond the mesh and the rays, diffuse rays: kept after a call and at the peak, "
      "of the process, and as announced to the memory monitor. Peak ratio: dacrt's over "
      "Embree's.",
      std::move(table)};
}

std::vector<Section> Sections(const EmbreeResults& results) {
  std::vector<Section> sections;
  sections.push_back(Goals(results));
  sections.push_back(Summary(results));
  sections.push_back(Cells(results));
  sections.push_back(Memory(results));
  return sections;
}

std::string Conditions(const EmbreeResults& results) {
  return results.processor + ", median of " + std::to_string(results.repeat) + " rounds or more";
}

}  // namespace

void PrintText(const EmbreeResults& results, std::ostream& out) {
  out << Conditions(results) << '\n';
  for (const Section& section : Sections(results)) {
    out << '\n' << section.title << "\n\n" << section.note << '\n';
    section.table.Print(out);
  }
}

void PrintMarkdown(const EmbreeResults& results, std::ostream& out) {
  out << Conditions(results) << ":\n\n```sh\n" << results.command << "\n```\n";
  for (const Section& section : Sections(results)) {
    out << "\n## " << section.title << "\n\n" << section.note << "\n\n";
    section.table.PrintMarkdown(out);
  }
}

}  // namespace dacrt::bench
