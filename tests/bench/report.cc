#include "report.h"

#include <algorithm>
#include <iterator>
#include <ostream>
#include <string_view>

#include "format.h"
#include "paper.h"
#include "table.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

constexpr double kMillion = 1e6;

std::vector<std::string> FrameCells(const FrameResult& frame) {
  return {frame.scene, frame.kind->name, Squared(frame.raster.rays_a_side())};
}

// Of the frames that differ in the number of rays only, those with the most. In order.
std::vector<const FrameResult*> LargestFrames(const std::vector<FrameResult>& frames) {
  std::vector<const FrameResult*> largest;
  for (const FrameResult& frame : frames) {
    const auto same = std::ranges::find_if(largest, [&](const FrameResult* other) {
      return other->scene == frame.scene && other->kind == frame.kind;
    });
    if (same == largest.end()) {
      largest.push_back(&frame);
    } else if (frame.raster.RayCount() > (*same)->raster.RayCount()) {
      *same = &frame;
    }
  }
  return largest;
}

// Geometric mean over `frames` of the time of one method over that of the first.
double MeanRatio(const std::vector<FrameResult>& frames, std::size_t method) {
  std::vector<double> ratios;
  for (const FrameResult& frame : frames) ratios.push_back(frame.Ratio(method, 0));
  return GeometricMean(ratios);
}

// Times and rates of every algorithm, and of all but the first their ratio to it.
void PrintComparison(const std::vector<FrameResult>& frames, std::ostream& out) {
  const std::vector<Method>& methods = frames.front().methods;
  std::vector<std::string> header = {"scene", "frame", "rays a pass", "triangles", "M rays"};
  for (const Method& method : methods) {
    header.push_back(method.name);
    header.push_back("least");
    header.push_back("M/s");
  }
  for (std::size_t i = 1; i < methods.size(); ++i) {
    header.push_back(methods[i].name + " x");
    header.push_back("paper");
  }
  constexpr std::size_t kLeft = 2;
  Table table(header, kLeft);
  for (const FrameResult& frame : frames) {
    std::vector<std::string> row = FrameCells(frame);
    row.push_back(Grouped(frame.triangles));
    row.push_back(Fixed(frame.Rays() / kMillion, 2));
    for (std::size_t i = 0; i < methods.size(); ++i) {
      row.push_back(Seconds(frame.Seconds(i)));
      row.push_back(Seconds(frame.LeastSeconds(i)));
      row.push_back(Fixed(frame.Rays() / frame.Seconds(i) / kMillion, 2));
    }
    for (std::size_t i = 1; i < methods.size(); ++i) {
      const auto paper = PaperRatio(frame, methods[i].name);
      row.push_back(Fixed(frame.Ratio(i, 0), 2));
      row.push_back(paper ? Fixed(*paper, 2) : "");
    }
    table.Add(std::move(row));
  }
  out << "\nSeconds for all passes of a frame: of each pass the median run; least: the fastest "
         "run.\n"
         "x: time over that of "
      << methods[0].name
      << ". Paper: 4096^2 rays a pass; its San Miguel stands beside scenes of a million "
         "triangles and more.\n\n";
  table.Print(out);
}

// Shares of the time, for the largest number of rays.
void PrintStages(const std::vector<FrameResult>& frames, std::ostream& out) {
  std::vector<std::string> header = {"scene", "frame", "rays a pass", "algorithm", "s"};
  for (const Stage& stage : kStages) header.push_back(std::string(stage.name) + " %");
  header.insert(header.end(), {"rest %", "box tests a ray", "triangle tests a ray", "memory MB"});
  constexpr std::size_t kLeft = 4;
  Table table(header, kLeft);
  for (const FrameResult* const frame : LargestFrames(frames)) {
    for (std::size_t i = 0; i < frame->methods.size(); ++i) {
      const double seconds = frame->Seconds(i);
      const Statistics total = frame->Total(i);
      const double rays = std::max<double>(frame->Rays(), 1);
      std::vector<std::string> row = FrameCells(*frame);
      row.push_back(frame->methods[i].name);
      row.push_back(Seconds(seconds));
      for (const Stage& stage : kStages)
        row.push_back(Fixed(100 * total.*stage.seconds / seconds, 1));
      row.push_back(Fixed(100 * RestOf(total, seconds) / seconds, 1));
      row.push_back(Fixed(total.box_tests / rays, 1));
      row.push_back(Fixed(total.triangle_tests / rays, 1));
      row.push_back(Fixed(frame->workspace_bytes[i] / kMillion, 1));
      table.Add(std::move(row));
    }
  }
  out << "\nWhere the time goes, and the workspace held.\n\n";
  table.Print(out);
}

// What each change of the settings costs, by kind of frame, over all scenes.
void PrintAblation(const std::vector<FrameResult>& frames, std::ostream& out) {
  std::vector<std::vector<FrameResult>> by_kind;
  std::vector<std::string> header = {"setting"};
  for (const FrameKind& kind : FrameKinds()) {
    std::vector<FrameResult> of_kind;
    std::ranges::copy_if(frames, std::back_inserter(of_kind),
                         [&](const FrameResult& frame) { return frame.kind == &kind; });
    if (of_kind.empty()) continue;
    by_kind.push_back(std::move(of_kind));
    header.push_back(kind.name);
  }
  header.insert(header.end(), {"all", "least", "most"});
  Table table(header, 1);
  const std::vector<Method>& methods = frames.front().methods;
  for (std::size_t i = 1; i < methods.size(); ++i) {
    std::vector<std::string> row = {methods[i].name};
    for (const auto& of_kind : by_kind) row.push_back(Fixed(MeanRatio(of_kind, i), 3));
    std::vector<double> ratios;
    for (const FrameResult& frame : frames) ratios.push_back(frame.Ratio(i, 0));
    const auto [least, most] = std::ranges::minmax(ratios);
    row.push_back(Fixed(MeanRatio(frames, i), 3));
    row.push_back(Fixed(least, 3));
    row.push_back(Fixed(most, 3));
    table.Add(std::move(row));
  }
  out << "\nOne setting changed: time over that of " << methods[0].name << ", "
      << Squared(frames.front().raster.rays_a_side())
      << " rays a pass, geometric mean over the scenes.\nAbove 1 the change costs time.\n\n";
  table.Print(out);
}

}  // namespace

void PrintReport(const Results& results, std::ostream& out) {
  out << results.processor << ", " << results.instruction_set << ", one thread, median of "
      << results.repeat << '\n';
  if (!results.comparison.empty()) {
    PrintComparison(results.comparison, out);
    PrintStages(results.comparison, out);
  }
  if (!results.ablation.empty()) PrintAblation(results.ablation, out);
}

}  // namespace dacrt::bench
