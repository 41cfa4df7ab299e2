#include "ratio_panels.h"

#include <algorithm>
#include <cmath>

#include "chart.h"

namespace dacrt::bench {
namespace {

constexpr double kWidth = 330, kHeight = 220;          // of a panel
constexpr double kLeft = 38, kTop = 22, kBottom = 30;  // around its axes
constexpr std::size_t kColumns = 2;

// Round ratios that reach from one value to the other: 1, 2 and 5 times powers of ten, or powers of
// ten alone where there would be too many.
std::vector<double> RatioTicks(double least, double most) {
  constexpr double kManyPowers = 1e4;
  std::vector<double> ticks;
  for (int power = -9; power <= 9; ++power) {
    for (const double factor : {1, 2, 5}) {
      if (factor == 1 || most / least < kManyPowers) ticks.push_back(factor * std::pow(10, power));
    }
  }
  const auto above = std::ranges::upper_bound(ticks, least);
  const auto end = std::ranges::lower_bound(ticks, most);
  return {above - 1, end + 1};
}

std::vector<double> TicksFor(const std::vector<RatioPanel>& panels) {
  double least = 1, most = 2;
  for (const RatioPanel& panel : panels) {
    for (const RatioLine& line : panel.lines) {
      for (const std::optional<double>& ratio : line.ratios) {
        if (ratio) least = std::min(least, *ratio);
        if (ratio) most = std::max(most, *ratio);
      }
    }
  }
  return RatioTicks(least, most);
}

class PanelPlot {
 public:
  PanelPlot(const std::vector<std::string>& sizes, const std::vector<RatioPanel>& panels)
      : sizes_(sizes), panels_(panels), ticks_(TicksFor(panels)) {}

  std::string Draw(const std::string& title) {
    svg_.Text({kMargin, kMargin + 10}, title, kTitle);
    for (std::size_t i = 0; i < panels_.size(); ++i) DrawPanel(Corner(i), panels_[i]);
    std::vector<LegendEntry> legend;
    for (const RatioLine& line : panels_.front().lines) {
      legend.push_back({line.name, Colour(legend.size())});
    }
    const double width = kMargin + kColumns * (kWidth + kMargin);
    DrawLegend(svg_, {width + kMargin, kMargin + kTitleHeight + kTop}, legend);
    constexpr double kLegendWidth = 150;
    return svg_.Finish(width + kLegendWidth, Corner(panels_.size() + kColumns - 1).y);
  }

 private:
  static Point Corner(std::size_t panel) {
    return {kMargin + (panel % kColumns) * (kWidth + kMargin),
            kMargin + kTitleHeight + (panel / kColumns) * (kHeight + kMargin)};
  }

  void DrawPanel(Point corner, const RatioPanel& panel) {
    constexpr double kInset = 0.3;  // of a column, from the first and the last to the frame
    const Scale x{-kInset, sizes_.size() - 1 + kInset, corner.x + kLeft, corner.x + kWidth};
    const Scale y{std::log(ticks_.front()), std::log(ticks_.back()), corner.y + kHeight - kBottom,
                  corner.y + kTop};
    svg_.Text({x.start, corner.y + 12}, panel.title, kHeading);
    for (const double tick : ticks_) {
      const double at = y(std::log(tick));
      svg_.Line({x.start, at}, {x.end, at}, kGrid);
      svg_.Text({x.start - 5, at + 4}, TickText(tick, std::min(tick, 1.0)),
                {.anchor = Anchor::kEnd});
    }
    svg_.Line({x.start, y(0)}, {x.end, y(0)}, kAxis);
    for (std::size_t i = 0; i < sizes_.size(); ++i) {
      svg_.Text({x(i), y.start + 16}, sizes_[i], {.anchor = Anchor::kMiddle});
    }
    for (std::size_t i = 0; i < panel.lines.size(); ++i) {
      std::vector<Point> points;
      const auto& ratios = panel.lines[i].ratios;
      for (std::size_t size = 0; size < ratios.size(); ++size) {
        if (ratios[size]) points.push_back({x(size), y(std::log(*ratios[size]))});
      }
      svg_.Polyline(points, Colour(i));
      for (const Point& point : points) svg_.Dot(point, 3, Colour(i));
    }
  }

  const std::vector<std::string>& sizes_;
  const std::vector<RatioPanel>& panels_;
  const std::vector<double> ticks_;
  Svg svg_;
};

}  // namespace

std::string DrawRatioPanels(const std::string& title, const std::vector<std::string>& sizes,
                            const std::vector<RatioPanel>& panels) {
  return PanelPlot(sizes, panels).Draw(title);
}

}  // namespace dacrt::bench
