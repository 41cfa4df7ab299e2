#include "embree_plots.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "batch_size.h"
#include "chart.h"
#include "isa.h"
#include "output_file.h"
#include "ray_kind.h"

namespace dacrt::bench {
namespace {

constexpr double kWidth = 330, kHeight = 220;          // of a panel
constexpr double kLeft = 38, kTop = 22, kBottom = 30;  // around its axes
constexpr std::size_t kColumns = 2;

struct Line {
  std::string name;
  double (CellResult::*ratio)() const;
  int threads;
};

class ScenePlot {
 public:
  ScenePlot(const std::vector<CellResult>& cells, const std::string& scene);

  std::string Draw();

 private:
  void DrawPanel(Point corner, const std::string& kind);
  void DrawLine(const Scale& x, const Scale& y, const std::string& kind, std::size_t line);

  std::vector<CellResult> cells_;
  const std::string scene_;
  std::vector<Line> lines_;
  std::vector<double> ticks_;  // ratios, from the least to the most
  Svg svg_;
};

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

bool IsPlotted(const Cell& cell) {
  return cell.geometry == "triangles" && cell.isa == IsasHere().front();
}

ScenePlot::ScenePlot(const std::vector<CellResult>& cells, const std::string& scene)
    : scene_(scene) {
  std::set<int> threads;
  double least = 1, most = 2;
  for (const CellResult& result : cells) {
    if (result.cell.scene != scene || !IsPlotted(result.cell)) continue;
    cells_.push_back(result);
    threads.insert(result.cell.threads);
    least = std::min(least, result.SteadyRatio());
    most = std::max(most, result.SteadyRatio());
    if (!result.HasOneShot()) continue;
    least = std::min(least, result.OneShotRatio());
    most = std::max(most, result.OneShotRatio());
  }
  for (const int count : threads) {
    const std::string on = count == 1 ? ", 1 thread" : ", " + std::to_string(count) + " threads";
    lines_.push_back({"one shot" + on, &CellResult::OneShotRatio, count});
    lines_.push_back({"steady" + on, &CellResult::SteadyRatio, count});
  }
  ticks_ = RatioTicks(least, most);
}

std::string ScenePlot::Draw() {
  svg_.Text({kMargin, kMargin + 10},
            scene_ + ": Embree's time over dacrt's, against the rays a call", kTitle);
  const auto corner = [](std::size_t panel) {
    return Point{kMargin + (panel % kColumns) * (kWidth + kMargin),
                 kMargin + kTitleHeight + (panel / kColumns) * (kHeight + kMargin)};
  };
  std::size_t panels = 0;
  for (const RayKind& kind : RayKinds()) {
    if (std::ranges::none_of(cells_, [&](const CellResult& r) { return r.cell.kind == kind.name; }))
      continue;
    DrawPanel(corner(panels++), kind.name);
  }
  std::vector<LegendEntry> legend;
  for (const Line& line : lines_) legend.push_back({line.name, Colour(legend.size())});
  const double width = kMargin + kColumns * (kWidth + kMargin);
  DrawLegend(svg_, {width + kMargin, kMargin + kTitleHeight + kTop}, legend);
  constexpr double kLegendWidth = 150;
  return svg_.Finish(width + kLegendWidth, corner(panels + panels % kColumns).y);
}

void ScenePlot::DrawPanel(Point corner, const std::string& kind) {
  constexpr double kInset = 0.3;  // of a column, from the first and the last to the frame
  const std::span<const BatchSize> sizes = BatchSizes();
  const Scale x{-kInset, sizes.size() - 1 + kInset, corner.x + kLeft, corner.x + kWidth};
  const Scale y{std::log(ticks_.front()), std::log(ticks_.back()), corner.y + kHeight - kBottom,
                corner.y + kTop};
  svg_.Text({x.start, corner.y + 12}, kind, kHeading);
  for (const double tick : ticks_) {
    const double at = y(std::log(tick));
    svg_.Line({x.start, at}, {x.end, at}, kGrid);
    svg_.Text({x.start - 5, at + 4}, TickText(tick, std::min(tick, 1.0)), {.anchor = Anchor::kEnd});
  }
  svg_.Line({x.start, y(0)}, {x.end, y(0)}, kAxis);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    svg_.Text({x(i), y.start + 16}, sizes[i].name, {.anchor = Anchor::kMiddle});
  }
  for (std::size_t line = 0; line < lines_.size(); ++line) DrawLine(x, y, kind, line);
}

void ScenePlot::DrawLine(const Scale& x, const Scale& y, const std::string& kind,
                         std::size_t line) {
  const auto& [name, ratio, threads] = lines_[line];
  std::vector<Point> points;
  for (const BatchSize& size : BatchSizes()) {
    const auto result = std::ranges::find_if(cells_, [&](const CellResult& result) {
      const Cell& cell = result.cell;
      return cell.kind == kind && cell.size == size.name && cell.threads == threads;
    });
    if (result == cells_.end()) continue;
    if (ratio == &CellResult::OneShotRatio && !result->HasOneShot()) continue;
    points.push_back({x(&size - BatchSizes().data()), y(std::log(((*result).*ratio)()))});
  }
  svg_.Polyline(points, Colour(line));
  for (const Point& point : points) svg_.Dot(point, 3, Colour(line));
}

}  // namespace

std::string EmbreePlot(const EmbreeResults& results, const std::string& scene) {
  return ScenePlot(results.cells, scene).Draw();
}

void WriteEmbreePlots(const EmbreeResults& results, const std::filesystem::path& folder) {
  std::set<std::string> scenes;
  for (const CellResult& result : results.cells) {
    if (IsPlotted(result.cell)) scenes.insert(result.cell.scene);
  }
  for (const std::string& scene : scenes) {
    const std::string stem = std::filesystem::path(scene).stem();  // of a name, the name
    WriteFile(folder / (stem + ".svg"), EmbreePlot(results, scene));
  }
}

}  // namespace dacrt::bench
