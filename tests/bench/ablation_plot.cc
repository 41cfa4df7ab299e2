#include <algorithm>
#include <cmath>

#include "chart.h"
#include "plots.h"
#include "report.h"

namespace dacrt::bench {

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
               RaysText(frames.front().raster) + " rays a pass",
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
    svg.Line({mean, y - kRow / 3}, {mean, y + kRow / 3}, kInk, 2);
    for (const FrameResult& frame : frames) {
      const auto kind = std::ranges::find(kinds, frame.kind);
      svg.Dot({x(frame.Ratio(i, 0)), y}, 3, Colour(kind - kinds.begin()));
    }
  }
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < kinds.size(); ++i) legend.push_back({kinds[i]->title, Colour(i)});
  DrawLegend(svg, {x.end + kMargin, top}, legend);
  return svg.Finish(x.end + kMargin + kLegend,
                    std::max(bottom, top + legend.size() * kLegendLine) + kMargin);
}

}  // namespace dacrt::bench
