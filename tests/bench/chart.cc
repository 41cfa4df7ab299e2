#include "chart.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "format.h"

namespace dacrt::bench {

const char* Colour(std::size_t i) {
  // Okabe and Ito's colours, which those who see few colours can tell apart, and some more.
  constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
                                      "#56b4e9", "#8c6d31", "#6a51a3", "#4d4d4d", "#c7b700"};
  return kColours[i % std::size(kColours)];
}

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

std::string RaysText(const Raster& raster) {
  return std::to_string(raster.rays_a_side()) + "\u00b2";
}

void DrawLegend(Svg& svg, Point corner, const std::vector<LegendEntry>& entries) {
  constexpr double kSwatch = 11;
  for (const LegendEntry& entry : entries) {
    svg.Rect(corner, kSwatch, kSwatch, entry.colour);
    svg.Text({corner.x + kSwatch + 6, corner.y + kSwatch - 1}, entry.text, {});
    corner.y += kLegendLine;
  }
}

std::vector<const FrameKind*> KindsIn(const std::vector<FrameResult>& frames) {
  std::vector<const FrameKind*> kinds;
  for (const FrameKind& kind : FrameKinds()) {
    if (std::ranges::find(frames, &kind, &FrameResult::kind) != frames.end())
      kinds.push_back(&kind);
  }
  return kinds;
}

}  // namespace dacrt::bench
