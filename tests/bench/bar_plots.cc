#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "chart.h"
#include "format.h"
#include "plots.h"
#include "report.h"

namespace dacrt::bench {
namespace {

constexpr double kLabels = 250, kBars = 520, kValues = 70, kLegend = 130;  // columns
constexpr double kHead = 24, kBar = 11, kGap = 8;                          // rows
constexpr const char* kRest = "#bbbbbb";

// A part of a bar, in seconds.
struct Segment {
  double seconds;
  const char* colour;
};

using SegmentsOf =
    std::function<std::vector<Segment>(const FrameResult& frame, std::size_t method)>;

// A panel for each kind of frame, in it a group of bars for each scene: a bar for each method, and
// its time at its end.
class BarChart {
 public:
  BarChart(const std::vector<FrameResult>& frames, SegmentsOf segments_of)
      : frames_(frames), segments_of_(std::move(segments_of)) {}

  std::string Draw(const std::string& title, const std::vector<LegendEntry>& legend);

 private:
  void DrawPanel(const FrameKind& kind, const std::vector<const FrameResult*>& frames);
  void DrawGroup(const Scale& x, const FrameResult& frame);

  const std::vector<FrameResult>& frames_;
  const SegmentsOf segments_of_;
  Svg svg_;
  double y_ = kMargin + kTitleHeight;  // how far down the drawing is done
};

std::string BarChart::Draw(const std::string& title, const std::vector<LegendEntry>& legend) {
  svg_.Text({kMargin, kMargin + 10}, title, kTitle);
  const Point corner{kMargin + kLabels + kBars + kValues, y_};
  DrawLegend(svg_, corner, legend);
  const std::vector<const FrameResult*> largest = LargestFrames(frames_);
  for (const FrameKind* const kind : KindsIn(frames_)) {
    std::vector<const FrameResult*> of_kind;
    std::ranges::copy_if(largest, std::back_inserter(of_kind),
                         [kind](const FrameResult* frame) { return frame->kind == kind; });
    DrawPanel(*kind, of_kind);
  }
  return svg_.Finish(corner.x + kLegend,
                     std::max(y_, corner.y + legend.size() * kLegendLine) + kMargin);
}

void BarChart::DrawPanel(const FrameKind& kind, const std::vector<const FrameResult*>& frames) {
  double most = 0;
  double height = 0;
  for (const FrameResult* const frame : frames) {
    for (std::size_t i = 0; i < frame->methods.size(); ++i) {
      most = std::max(most, frame->Seconds(i));
      height += kBar;
    }
    height += kGap;
  }
  const Scale x{0, most, kMargin + kLabels, kMargin + kLabels + kBars};
  svg_.Text({kMargin, y_ + 12}, kind.title, kHeading);
  y_ += kHead;
  const double step = NiceStep(most);
  for (double tick = 0; tick <= most; tick += step) {
    svg_.Line({x(tick), y_}, {x(tick), y_ + height}, kGrid);
    svg_.Text({x(tick), y_ - 4}, TickText(tick, step) + (tick == 0 ? " s" : ""),
              {.anchor = Anchor::kMiddle, .size = 9, .colour = kAxis});
  }
  for (const FrameResult* const frame : frames) DrawGroup(x, *frame);
  y_ += kGap;
}

void BarChart::DrawGroup(const Scale& x, const FrameResult& frame) {
  svg_.Text({kMargin, y_ + kBar - 2}, frame.scene + ", " + RaysText(frame.raster), {});
  for (std::size_t i = 0; i < frame.methods.size(); ++i) {
    svg_.Text({x.start - 6, y_ + kBar - 2}, frame.methods[i].name,
              {.anchor = Anchor::kEnd, .size = 10});
    double done = 0;
    for (const Segment& segment : segments_of_(frame, i)) {
      svg_.Rect({x(done), y_}, x(segment.seconds) - x(0), kBar - 1, segment.colour);
      done += segment.seconds;
    }
    svg_.Text({x(done) + 5, y_ + kBar - 2}, Seconds(frame.Seconds(i)) + " s",
              {.size = 9, .colour = kAxis});
    y_ += kBar;
  }
  y_ += kGap;
}

}  // namespace

std::string TimePlot(const std::vector<FrameResult>& frames) {
  std::vector<LegendEntry> legend;
  const std::vector<Method>& methods = frames.front().methods;
  for (std::size_t i = 0; i < methods.size(); ++i) legend.push_back({methods[i].name, Colour(i)});
  BarChart chart(frames, [](const FrameResult& frame, std::size_t method) {
    return std::vector<Segment>{{frame.Seconds(method), Colour(method)}};
  });
  return chart.Draw("Time of a frame", legend);
}

std::string StagePlot(const std::vector<FrameResult>& frames) {
  std::vector<LegendEntry> legend;
  for (std::size_t i = 0; i < std::size(kStages); ++i) {
    legend.push_back({kStages[i].name, Colour(i)});
  }
  legend.push_back({"rest", kRest});
  BarChart chart(frames, [](const FrameResult& frame, std::size_t method) {
    const Statistics total = frame.Total(method);
    std::vector<Segment> segments;
    for (std::size_t i = 0; i < std::size(kStages); ++i) {
      segments.push_back({total.*kStages[i].seconds, Colour(i)});
    }
    segments.push_back({RestOf(total, frame.Seconds(method)), kRest});
    return segments;
  });
  return chart.Draw("Where the time goes", legend);
}

}  // namespace dacrt::bench
