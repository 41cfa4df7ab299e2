#include "plots.h"

#include "output_file.h"

namespace dacrt::bench {

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
