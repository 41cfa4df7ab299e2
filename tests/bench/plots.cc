#include "plots.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "format.h"
#include "output_file.h"
#include "report.h"
#include "svg.h"

namespace dacrt::bench {
namespace {

using Anchor = Svg::Anchor;
using Point = Svg::Point;

// Okabe and Ito's colours, which those who see few colours can tell apart, and four more.
constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
                                    "#56b4e9", "#8c6d31", "#6a51a3", "#4d4d4d", "#c7b700"};
constexpr const char* kGrid = "#dddddd";
constexpr const char* kAxis = "#888888";

const char* Colour(std::size_t i) { return kColours[i % std::size(kColours)]; }

constexpr double kMargin = 16;
constexpr double kTitleHeight = 30;
constexpr Svg::TextStyle kTitle{.size = 15, .bold = true};
constexpr Svg::TextStyle kHeading{.size = 12, .bold = true};

// A step of 1, 2 or 5 times a power of ten, of which about five make up `range`.
double NiceStep(double range) {
  const double rough = std::max(range, 1e-9) / 5;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

std::string TickText(double value, double step) {
  return Fixed(value, std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-6))));
}

// Maps [from, to] onto [start, end] of the drawing.
struct Scale {
  double from, to, start, end;
  double operator()(double value) const {
    return start + (value - from) / (to - from) * (end - start);
  }
};

struct LegendEntry {
  std::string text;
  const char* colour;
};

void DrawLegend(Svg& svg, Point corner, const std::vector<LegendEntry>& entries) {
  constexpr double kLine = 18;
  constexpr double kSwatch = 11;
  for (const LegendEntry& entry : entries) {
    svg.Rect(corner, kSwatch, kSwatch, entry.colour);
    svg.Text({corner.x + kSwatch + 6, corner.y + kSwatch - 1}, entry.text, {});
    corner.y += kLine;
  }
}

// The kinds of frame that occur, in their order.
std::vector<const FrameKind*> KindsIn(const std::vector<FrameResult>& frames) {
  std::vector<const FrameKind*> kinds;
  for (const FrameKind& kind : FrameKinds()) {
    if (std::ranges::find(frames, &kind, &FrameResult::kind) != frames.end())
      kinds.push_back(&kind);
  }
  return kinds;
}

std::vector<std::string> ScenesIn(const std::vector<FrameResult>& frames) {
  std::vector<std::string> scenes;
  for (const FrameResult& frame : frames) {
    if (std::ranges::find(scenes, frame.scene) == scenes.end()) scenes.push_back(frame.scene);
  }
  return scenes;
}

// A panel for each kind of frame and a line for each scene: the ratio against the number of rays.
std::string RatioPlot(const std::vector<FrameResult>& frames, std::size_t rival) {
  constexpr double kWidth = 300, kHeight = 210, kLeft = 38, kBottom = 38;
  constexpr std::size_t kColumns = 3;
  const std::vector<const FrameKind*> kinds = KindsIn(frames);
  const std::vector<std::string> scenes = ScenesIn(frames);
  std::set<uint32_t> sides;
  double least = 1, most = 1;
  for (const FrameResult& frame : frames) {
    sides.insert(frame.raster.rays_a_side());
    least = std::min(least, frame.Ratio(rival, 0));
    most = std::max(most, frame.Ratio(rival, 0));
  }
  const double step = NiceStep(most - least);
  least = std::floor(least / step) * step;
  most = std::max(std::ceil(most / step) * step, least + step);

  Svg svg;
  const std::string& reference = frames.front().methods[0].name;
  svg.Text({kMargin, kMargin + 10},
           "Time of " + frames.front().methods[rival].name + " over time of " + reference +
               ", against the rays a pass",
           kTitle);
  const auto corner_of = [&](std::size_t cell) {
    return Point{kMargin + (cell % kColumns) * (kWidth + kMargin),
                 kMargin + kTitleHeight + (cell / kColumns) * (kHeight + kMargin)};
  };
  for (std::size_t cell = 0; cell < kinds.size(); ++cell) {
    const Point corner = corner_of(cell);
    const Scale x{-0.3, sides.size() - 0.7, corner.x + kLeft, corner.x + kWidth};
    const Scale y{least, most, corner.y + kHeight - kBottom, corner.y + 22};
    svg.Text({corner.x + kLeft, corner.y + 12}, kinds[cell]->title, kHeading);
    for (double tick = least; tick < most + step / 2; tick += step) {
      svg.Line({x.start, y(tick)}, {x.end, y(tick)}, kGrid);
      svg.Text({x.start - 5, y(tick) + 4}, TickText(tick, step), {.anchor = Anchor::kEnd});
    }
    svg.Line({x.start, y(1)}, {x.end, y(1)}, kAxis);
    for (const uint32_t side : sides) {
      const double column = std::distance(sides.begin(), sides.find(side));
      svg.Text({x(column), y.start + 16}, Squared(side), {.anchor = Anchor::kMiddle});
    }
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      std::map<uint32_t, double> ratios;  // by side
      for (const FrameResult& frame : frames) {
        if (frame.scene != scenes[i] || frame.kind != kinds[cell]) continue;
        ratios[frame.raster.rays_a_side()] = frame.Ratio(rival, 0);
      }
      std::vector<Point> points;
      for (const auto& [side, ratio] : ratios) {
        points.push_back({x(std::distance(sides.begin(), sides.find(side))), y(ratio)});
      }
      svg.Polyline(points, Colour(i));
      for (const Point& point : points) svg.Dot(point, 3, Colour(i));
    }
  }
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < scenes.size(); ++i) legend.push_back({scenes[i], Colour(i)});
  const Point legend_corner = corner_of(kinds.size());
  DrawLegend(svg, {legend_corner.x + kLeft, legend_corner.y + 22}, legend);
  const double rows = static_cast<double>(kinds.size() / kColumns + 1);
  const double columns = static_cast<double>(std::min(kinds.size() + 1, kColumns));
  return svg.Finish(kMargin + columns * (kWidth + kMargin),
                    kMargin + kTitleHeight + rows * (kHeight + kMargin));
}

struct Segment {
  double length;
  const char* colour;
};

// A panel for each kind of frame, a group of bars for each scene, and a bar for each method, made
// of segments that `segments_of` gives; the bar's end is marked with the time.
template <class SegmentsOf>
std::string BarPlot(const std::vector<FrameResult>& frames, const std::string& title,
                    const std::vector<LegendEntry>& legend, bool name_methods,
                    const SegmentsOf& segments_of) {
  constexpr double kLabels = 250, kBars = 520, kValues = 70, kBar = 11, kGap = 8, kHead = 24;
  constexpr double kLegend = 130;
  Svg svg;
  svg.Text({kMargin, kMargin + 10}, title, kTitle);
  double y = kMargin + kTitleHeight;
  const double legend_y = y;
  const std::vector<const FrameResult*> largest = LargestFrames(frames);
  for (const FrameKind* const kind : KindsIn(frames)) {
    std::vector<const FrameResult*> of_kind;
    double most = 0;
    for (const FrameResult* frame : largest) {
      if (frame->kind != kind) continue;
      of_kind.push_back(frame);
      for (std::size_t i = 0; i < frame->methods.size(); ++i)
        most = std::max(most, frame->Seconds(i));
    }
    const double step = NiceStep(most);
    const Scale x{0, std::max(most, step), kMargin + kLabels, kMargin + kLabels + kBars};
    double height = 0;
    for (const FrameResult* frame : of_kind) height += frame->methods.size() * kBar + kGap;
    svg.Text({kMargin, y + 12}, kind->title, kHeading);
    y += kHead;
    for (double tick = 0; tick <= x.to; tick += step) {
      svg.Line({x(tick), y}, {x(tick), y + height}, kGrid);
      svg.Text({x(tick), y - 4}, TickText(tick, step) + (tick == 0 ? " s" : ""),
               {.anchor = Anchor::kMiddle, .size = 9, .colour = kAxis});
    }
    for (const FrameResult* frame : of_kind) {
      svg.Text({kMargin, y + kBar - 2}, frame->scene + ", " + Squared(frame->raster.rays_a_side()),
               {});
      for (std::size_t i = 0; i < frame->methods.size(); ++i) {
        if (name_methods) {
          svg.Text({x.start - 6, y + kBar - 2}, frame->methods[i].name,
                   {.anchor = Anchor::kEnd, .size = 10});
        }
        double done = 0;
        for (const Segment& segment : segments_of(*frame, i)) {
          svg.Rect({x(done), y}, x(segment.length) - x(0), kBar - 1, segment.colour);
          done += segment.length;
        }
        svg.Text({x(done) + 5, y + kBar - 2}, Seconds(frame->Seconds(i)) + " s",
                 {.size = 9, .colour = kAxis});
        y += kBar;
      }
      y += kGap;
    }
    y += kGap;
  }
  const double legend_x = kMargin + kLabels + kBars + kValues;
  DrawLegend(svg, {legend_x, legend_y}, legend);
  constexpr double kLegendLine = 18;
  return svg.Finish(legend_x + kLegend + kMargin,
                    std::max(y, legend_y + legend.size() * kLegendLine) + kMargin);
}

std::string TimePlot(const std::vector<FrameResult>& frames) {
  std::vector<LegendEntry> legend;
  const std::vector<Method>& methods = frames.front().methods;
  for (std::size_t i = 0; i < methods.size(); ++i) legend.push_back({methods[i].name, Colour(i)});
  return BarPlot(frames, "Time of a frame", legend, false,
                 [](const FrameResult& frame, std::size_t method) {
                   return std::vector<Segment>{{frame.Seconds(method), Colour(method)}};
                 });
}

std::string StagePlot(const std::vector<FrameResult>& frames) {
  constexpr const char* kRest = "#bbbbbb";
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < std::size(kStages); ++i)
    legend.push_back({kStages[i].name, Colour(i)});
  legend.push_back({"rest", kRest});
  return BarPlot(frames, "Where the time goes", legend, true,
                 [](const FrameResult& frame, std::size_t method) {
                   const Statistics total = frame.Total(method);
                   std::vector<Segment> segments;
                   for (std::size_t i = 0; i < std::size(kStages); ++i) {
                     segments.push_back({total.*kStages[i].seconds, Colour(i)});
                   }
                   segments.push_back({RestOf(total, frame.Seconds(method)), kRest});
                   return segments;
                 });
}

// A row for each changed setting, a dot for each frame, and a bar at their geometric mean.
std::string AblationPlot(const std::vector<FrameResult>& frames) {
  constexpr double kLabels = 170, kWidth = 560, kRow = 24, kLegend = 190;
  const std::vector<Method>& methods = frames.front().methods;
  const std::vector<const FrameKind*> kinds = KindsIn(frames);
  double least = 1, most = 1;
  for (const FrameResult& frame : frames) {
    for (std::size_t i = 1; i < methods.size(); ++i) {
      least = std::min(least, frame.Ratio(i, 0));
      most = std::max(most, frame.Ratio(i, 0));
    }
  }
  const double step = NiceStep(most - least);
  const double top = kMargin + kTitleHeight + 12;
  const double bottom = top + (methods.size() - 1) * kRow;
  const Scale x{std::floor(least / step) * step, std::ceil(most / step) * step + step / 4,
                kMargin + kLabels, kMargin + kLabels + kWidth};
  Svg svg;
  svg.Text({kMargin, kMargin + 10},
           "One setting changed: time over that of " + methods[0].name + ", " +
               Squared(frames.front().raster.rays_a_side()) + " rays a pass",
           kTitle);
  for (double tick = x.from; tick <= x.to; tick += step) {
    svg.Line({x(tick), top}, {x(tick), bottom}, kGrid);
    svg.Text({x(tick), top - 4}, TickText(tick, step), {.anchor = Anchor::kMiddle});
  }
  svg.Dashes({x(1), top}, {x(1), bottom}, kAxis);
  for (std::size_t i = 1; i < methods.size(); ++i) {
    const double y = top + (i - 0.5) * kRow;
    svg.Text({x.start - 8, y + 4}, methods[i].name, {.anchor = Anchor::kEnd});
    const double mean = x(MeanRatio(frames, i));
    svg.Line({mean, y - kRow / 3}, {mean, y + kRow / 3}, "#222222", 2);
    for (const FrameResult& frame : frames) {
      const auto kind = std::ranges::find(kinds, frame.kind);
      svg.Dot({x(frame.Ratio(i, 0)), y}, 3, Colour(kind - kinds.begin()));
    }
  }
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < kinds.size(); ++i) legend.push_back({kinds[i]->title, Colour(i)});
  DrawLegend(svg, {x.end + kMargin, top}, legend);
  return svg.Finish(x.end + kMargin + kLegend, bottom + kMargin + 80);
}

}  // namespace

void WritePlots(const Results& results, const std::filesystem::path& folder) {
  if (!results.comparison.empty()) {
    const std::vector<Method>& methods = results.comparison.front().methods;
    for (std::size_t i = 1; i < methods.size(); ++i) {
      WriteFile(folder / ("ratio-" + methods[i].name + ".svg"), RatioPlot(results.comparison, i));
    }
    WriteFile(folder / "time.svg", TimePlot(results.comparison));
    WriteFile(folder / "stages.svg", StagePlot(results.comparison));
  }
  if (!results.ablation.empty()) WriteFile(folder / "ablation.svg", AblationPlot(results.ablation));
}

}  // namespace dacrt::bench
