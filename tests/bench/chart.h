// What the plots share: colours, axes, legends.
#pragma once

#include <string>
#include <vector>

#include "measure.h"
#include "svg.h"

namespace dacrt::bench {

// A text's anchor on the left, in the middle or on the right of where it stands.
using Anchor = Svg::Anchor;
using Point = Svg::Point;

inline constexpr const char* kGrid = "#dddddd";
inline constexpr const char* kAxis = "#888888";
inline constexpr const char* kInk = "#222222";

inline constexpr double kMargin = 16;
inline constexpr double kTitleHeight = 30;
inline constexpr Svg::TextStyle kTitle{.size = 15, .bold = true};
inline constexpr Svg::TextStyle kHeading{.size = 12, .bold = true};

/// The colour of the i-th of several things.
const char* Colour(std::size_t i);

/// A step of 1, 2 or 5 times a power of ten, of which about five make up `range`.
double NiceStep(double range);

/// `value`, with the digits that multiples of `step` have.
std::string TickText(double value, double step);

/// The number of rays of a raster, as N with a raised 2.
std::string RaysText(const Raster& raster);

/// Maps [from, to] onto [start, end] of the drawing.
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

inline constexpr double kLegendLine = 18;

/// One entry a line, downwards from `corner`.
void DrawLegend(Svg& svg, Point corner, const std::vector<LegendEntry>& entries);

/// The kinds of frame that occur, in their order.
std::vector<const FrameKind*> KindsIn(const std::vector<FrameResult>& frames);

}  // namespace dacrt::bench
