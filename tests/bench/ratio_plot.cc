#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "chart.h"
#include "format.h"
#include "paper.h"
#include "plots.h"

namespace dacrt::bench {
namespace {

constexpr double kWidth = 300, kHeight = 210;          // of a panel
constexpr double kLeft = 38, kTop = 22, kBottom = 38;  // around its axes
constexpr std::size_t kColumns = 3;

class RatioChart {
 public:
  RatioChart(const std::vector<FrameResult>& frames, std::size_t rival);

  std::string Draw();

 private:
  // Of a panel, or of the legend, which comes after the last one.
  static Point Corner(std::size_t cell) {
    return {kMargin + (cell % kColumns) * (kWidth + kMargin),
            kMargin + kTitleHeight + (cell / kColumns) * (kHeight + kMargin)};
  }

  void DrawPanel(Point corner, const FrameKind& kind);
  void DrawScene(const Scale& x, const Scale& y, const FrameKind& kind, std::size_t scene);

  // The sides of the rasters stand next to each other, whatever their ratio.
  double Column(const Raster& raster) const {
    return static_cast<double>(std::distance(sides_.begin(), sides_.find(raster.rays_a_side())));
  }

  const std::vector<FrameResult>& frames_;
  const std::size_t rival_;
  const std::string& rival_name_;
  std::vector<std::string> scenes_;
  std::set<uint32_t> sides_;
  double least_ = 1, most_ = 1, step_;
  Svg svg_;
};

RatioChart::RatioChart(const std::vector<FrameResult>& frames, std::size_t rival)
    : frames_(frames), rival_(rival), rival_name_(frames.front().methods[rival].name) {
  for (const FrameResult& frame : frames) {
    if (std::ranges::find(scenes_, frame.scene) == scenes_.end()) scenes_.push_back(frame.scene);
    sides_.insert(frame.raster.rays_a_side());
    const double paper = PaperRatio(frame, rival_name_).value_or(1);
    least_ = std::min({least_, frame.Ratio(rival, 0), paper});
    most_ = std::max({most_, frame.Ratio(rival, 0), paper});
  }
  step_ = NiceStep(most_ - least_);
  least_ = std::floor(least_ / step_) * step_;
  most_ = std::max(std::ceil(most_ / step_) * step_, least_ + step_);
}

std::string RatioChart::Draw() {
  svg_.Text({kMargin, kMargin + 10},
            "Time of " + rival_name_ + " over time of " + frames_.front().methods[0].name +
                ", against the rays a pass",
            kTitle);
  const std::vector<const FrameKind*> kinds = KindsIn(frames_);
  for (std::size_t i = 0; i < kinds.size(); ++i) DrawPanel(Corner(i), *kinds[i]);
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < scenes_.size(); ++i) legend.push_back({scenes_[i], Colour(i)});
  const Point corner = Corner(kinds.size());
  DrawLegend(svg_, {corner.x + kLeft, corner.y + kTop}, legend);

  const Point last_row = Corner(kinds.size());
  const double columns = static_cast<double>(std::min(kinds.size() + 1, kColumns));
  return svg_.Finish(kMargin + columns * (kWidth + kMargin), last_row.y + kHeight);
}

void RatioChart::DrawPanel(Point corner, const FrameKind& kind) {
  constexpr double kInset = 0.3;  // of a column, from the first and the last to the frame
  const Scale x{-kInset, sides_.size() - 1 + kInset, corner.x + kLeft, corner.x + kWidth};
  const Scale y{least_, most_, corner.y + kHeight - kBottom, corner.y + kTop};
  svg_.Text({x.start, corner.y + 12}, kind.title, kHeading);
  for (double tick = least_; tick < most_ + step_ / 2; tick += step_) {
    svg_.Line({x.start, y(tick)}, {x.end, y(tick)}, kGrid);
    svg_.Text({x.start - 5, y(tick) + 4}, TickText(tick, step_), {.anchor = Anchor::kEnd});
  }
  svg_.Line({x.start, y(1)}, {x.end, y(1)}, kAxis);
  for (const uint32_t side : sides_) {
    svg_.Text({x(Column(Raster(side))), y.start + 16}, RaysText(Raster(side)),
              {.anchor = Anchor::kMiddle});
  }

  std::set<double> papers;
  for (const FrameResult& frame : frames_) {
    if (frame.kind != &kind) continue;
    if (const auto paper = PaperRatio(frame, rival_name_)) papers.insert(*paper);
  }
  for (const double paper : papers) {
    svg_.Dashes({x.start, y(paper)}, {x.end, y(paper)}, kAxis);
    svg_.Text({x.end, y(paper) - 3}, "paper " + Fixed(paper, 2),
              {.anchor = Anchor::kEnd, .size = 9, .colour = kAxis});
  }
  for (std::size_t scene = 0; scene < scenes_.size(); ++scene) DrawScene(x, y, kind, scene);
}

void RatioChart::DrawScene(const Scale& x, const Scale& y, const FrameKind& kind,
                           std::size_t scene) {
  std::map<double, double> ratios;  // by column
  for (const FrameResult& frame : frames_) {
    if (frame.scene != scenes_[scene] || frame.kind != &kind) continue;
    ratios[Column(frame.raster)] = frame.Ratio(rival_, 0);
  }
  std::vector<Point> points;
  for (const auto& [column, ratio] : ratios) points.push_back({x(column), y(ratio)});
  svg_.Polyline(points, Colour(scene));
  for (const Point& point : points) svg_.Dot(point, 3, Colour(scene));
}

}  // namespace

std::string RatioPlot(const std::vector<FrameResult>& frames, std::size_t rival) {
  return RatioChart(frames, rival).Draw();
}

}  // namespace dacrt::bench
