#include "paper.h"

namespace dacrt::bench {
namespace {

struct Figure {
  std::string_view rival;
  std::string_view kind;
  std::string_view scene;  // empty: any
  std::size_t least_triangles;
  double ratio;
};

// Nabata et al. 2013, slides "Results (1/3)" and "(2/3)", "Performance Comparison to Mora's
// Method".
constexpr Figure kFigures[] = {
    {"afra2012", "point", "sibenik", 0, 27.3 / 14.7},
    {"afra2012", "area", "sibenik", 0, 22.3 / 11.5},
    {"afra2012", "path", "sponza", 0, 136.0 / 98.0},
    {"afra2012", "path-dof", "", 1'000'000, 216.0 / 173.0},
    {"mora2011", "path", "", 0, 1.85},
};

}  // namespace

std::optional<double> PaperRatio(const FrameResult& frame, std::string_view rival) {
  if (frame.methods.front().name != Name(Algorithm::kNabata2013)) return std::nullopt;
  for (const Figure& figure : kFigures) {
    if (figure.rival == rival && figure.kind == frame.kind->name &&
        (figure.scene.empty() || figure.scene == frame.scene) &&
        frame.triangles >= figure.least_triangles) {
      return figure.ratio;
    }
  }
  return std::nullopt;
}

}  // namespace dacrt::bench
