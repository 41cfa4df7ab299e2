#include "moving_report.h"

#include <algorithm>
#include <ostream>
#include <set>
#include <utility>

#include "format.h"
#include "moving_cells.h"
#include "moving_content.h"
#include "sections.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

std::vector<GoalSample> Samples(const MovingResults& results,
                                const std::vector<std::string>& changes) {
  std::vector<GoalSample> samples;
  for (const MovingResult& result : results.cells) {
    if (std::ranges::find(changes, result.cell.change) == changes.end()) continue;
    samples.push_back({result.Ratio(), Name(result.cell), result.cell.change});
  }
  return samples;
}

std::string Milliseconds(const std::vector<double>& seconds) {
  return Significant(Median(seconds) * 1e3);
}

// Of the cells of a change, a size and a number of threads.
std::string MeanOf(const MovingResults& results, const std::string& change, const std::string& kind,
                   int threads, const std::string& size) {
  std::vector<double> ratios;
  for (const MovingResult& result : results.cells) {
    const MovingCell& cell = result.cell;
    if (cell.change == change && cell.kind == kind && cell.threads == threads && cell.size == size)
      ratios.push_back(result.Ratio());
  }
  return ratios.empty() ? "" : Significant(GeometricMean(ratios));
}

std::set<int> ThreadsIn(const MovingResults& results) {
  std::set<int> threads;
  for (const MovingResult& result : results.cells) threads.insert(result.cell.threads);
  return threads;
}

Section ByChange(const MovingResults& results) {
  std::vector<std::string> header = {"change", "rays", "threads"};
  for (const FrameSize& size : FrameSizes()) header.push_back(size.name);
  constexpr std::size_t kLeft = 2;
  Table table(header, kLeft);
  for (const ChangeKind& change : ChangeKinds()) {
    for (const std::string& kind : MovingRayKinds()) {
      for (const int threads : ThreadsIn(results)) {
        std::vector<std::string> row = {change.name, kind, std::to_string(threads)};
        bool is_measured = false;
        for (const FrameSize& size : FrameSizes()) {
          row.push_back(MeanOf(results, change.name, kind, threads, size.name));
          is_measured |= !row.back().empty();
        }
        if (is_measured) table.Add(std::move(row));
      }
    }
  }
  return {"By change", "Against the rays a frame: geometric means over the scenes.",
          std::move(table)};
}

Section Cells(const MovingResults& results) {
  constexpr std::size_t kLeft = 4;
  Table table({"scene", "change", "rays", "size", "triangles", "threads", "Embree commit", "stream",
               "frame", "dacrt commit", "stream", "frame", "x", "Embree's best"},
              kLeft);
  for (const MovingResult& result : results.cells) {
    const MovingCell& cell = result.cell;
    std::vector<std::string> row = {cell.scene,
                                    cell.change,
                                    cell.kind,
                                    cell.size,
                                    Grouped(result.triangles),
                                    std::to_string(cell.threads)};
    for (const FrameTimes* const times : {&result.embree, &result.dacrt}) {
      row.push_back(Milliseconds(times->commit));
      row.push_back(Milliseconds(times->stream));
      row.push_back(Significant(times->Frame() * 1e3));
    }
    row.push_back(Significant(result.Ratio()));
    row.push_back(result.embree_best);
    table.Add(std::move(row));
  }
  return {"Cells", "Milliseconds, each the median over the frames.", std::move(table)};
}

std::vector<Section> Sections(const MovingResults& results) {
  std::vector<Section> sections;
  sections.push_back({"Goals",
                      "Ratios are Embree's time of a frame over dacrt's: above 1 dacrt is faster. "
                      "One shot on a new scene, the speed of a still scene and the memory are "
                      "measured by the comparison on still scenes, EMBREE.md.",
                      GoalsTable(JudgeGoals(results))});
  sections.push_back(ByChange(results));
  sections.push_back(Cells(results));
  return sections;
}

Conditions ConditionsOf(const MovingResults& results) {
  return {"dacrt beside Embree, on scenes that move", results.command, results.processor,
          results.repeat};
}

}  // namespace

std::vector<Goal> JudgeGoals(const MovingResults& results) {
  using enum Goal::Judged;
  std::vector<Goal> goals;
  const auto at_least = [&](double goal, const char* figure, Goal::Judged judged,
                            const std::vector<GoalSample>& samples) {
    goals.push_back(Judge(figure, judged, Goal::Bound::kAtLeast, goal, samples));
  };
  const auto waves = Samples(results, {"wave"});
  at_least(1.6, "waves", kGeometricMean, waves);
  at_least(1.0, "waves", kWorstCell, waves);
  const auto replaced = Samples(results, {"replaced"});
  at_least(1.4, "replaced meshes", kGeometricMean, replaced);
  at_least(0.9, "replaced meshes", kWorstCell, replaced);
  const auto parts = Samples(results, {"one-of-1000", "instances"});
  at_least(3, "one mesh of a thousand, instances moving", kGeometricMean, parts);
  at_least(3, "each of the two", kWorstMean, parts);
  return goals;
}

void PrintText(const MovingResults& results, std::ostream& out) {
  PrintSections(ConditionsOf(results), Sections(results), out);
}

void PrintMarkdown(const MovingResults& results, std::ostream& out) {
  PrintSectionsMarkdown(ConditionsOf(results), Sections(results), out);
}

}  // namespace dacrt::bench
