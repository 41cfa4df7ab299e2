// Ratios as plots: a panel for each group of lines, sizes across, on logarithmic scales.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace dacrt::bench {

struct RatioLine {
  std::string name;
  std::vector<std::optional<double>> ratios;  ///< one for each size, where there is one
};

/// Lines of the same names in the same order in every panel.
struct RatioPanel {
  std::string title;
  std::vector<RatioLine> lines;
};

/// As SVG.
std::string DrawRatioPanels(const std::string& title, const std::vector<std::string>& sizes,
                            const std::vector<RatioPanel>& panels);

}  // namespace dacrt::bench
