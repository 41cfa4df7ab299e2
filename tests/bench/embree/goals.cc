#include "goals.h"

#include <algorithm>
#include <utility>

#include "batch_size.h"
#include "cell_list.h"
#include "format.h"
#include "isa.h"

namespace dacrt::bench {
namespace {

using Bound = Goal::Bound;
using Judged = Goal::Judged;
using Samples = std::vector<GoalSample>;

constexpr std::size_t kMillionRays = 1 << 20;
constexpr std::size_t kSmallScene = 1000;  // triangles: below, a call costs more than its rays
constexpr std::size_t kLargeMesh = 250'000;
constexpr std::size_t kMillionTriangles = 1'000'000;

const BatchSize& SizeOf(const Cell& cell) { return *FindBatchSize(cell.size); }

bool IsPicture(const Cell& cell) { return !SizeOf(cell).IsSlice(); }

bool IsMainKind(const Cell& cell) {
  return std::ranges::find(MainKinds(), cell.kind) != MainKinds().end();
}

bool IsOf(const Cell& cell, const char* geometry, const std::string& isa) {
  return cell.geometry == geometry && cell.isa == isa;
}

class Figures {
 public:
  explicit Figures(const EmbreeResults& results) : results_(results) {}

  const std::vector<Goal>& goals() const { return goals_; }

  void OneShot() {
    Samples samples;
    for (const CellResult& result : results_.cells) {
      if (result.HasOneShot()) samples.push_back({result.OneShotRatio(), Name(result.cell), ""});
    }
    AtLeast(1.6, "one shot on a new scene", kMean, samples);
    AtLeast(0.95, "one shot on a new scene", kWorst, samples);
  }

  void SteadyPictures() {
    const Samples all =
        Steady([this](const Cell& cell) { return IsPlain(cell) && IsPicture(cell); });
    AtLeast(1.7, "steady, from 64K rays", kMean, all);
    AtLeast(0.9, "steady, from 64K rays", kWorst, all);
    for (const char* const kind : {"primary", "shadow", "primary-4", "shadow-4"}) {
      AtLeast(1.0, std::string("steady, from 64K rays, ") + kind, kMean,
              Steady([&](const Cell& cell) {
                return IsTriangles(cell) && IsPicture(cell) && cell.kind == kind;
              }));
    }
  }

  void SteadySlices() {
    for (const auto& [size, goal] :
         {std::pair("4K", 1.4), std::pair("1K", 1.15), std::pair("64", 0.9)}) {
      AtLeast(goal, std::string("steady, ") + size + " rays a call", kMean,
              Steady([this, &size = size](const Cell& cell) {
                return IsPlain(cell) && cell.size == size;
              }));
    }
  }

  void Calls() {
    Samples samples;
    for (const CellResult& result : results_.cells) {
      const Cell& cell = result.cell;
      if (!IsOf(cell, "triangles", best_isa_) || !IsMainKind(cell) || SizeOf(cell).IsStream()) {
        continue;
      }
      const std::string group =
          cell.scene + ", " + cell.size + " a call, " + ThreadsText(cell.threads);
      samples.push_back({result.SteadyRatio(), Name(cell), group});
    }
    AtLeast(1.0, "one ray a call; packets of 4, 8, 16", kMean, samples);
    AtLeast(0.9, "each of these, on each scene, from 1 and 2 threads", kWorstGroup, samples);
  }

  void LargestBatch() {
    AtLeast(2.5, "16M diffuse rays", kMean, Steady([this](const Cell& cell) {
              return IsPlain(cell) && cell.size == "16M" && cell.kind == "diffuse";
            }));
  }

  void OtherIsas() {
    for (const auto& [isa, goal] : {std::pair("avx2", 1.4), std::pair("sse4.2", 1.0)}) {
      AtLeast(goal, std::string(isa) + " against " + isa + ", from 64K rays", kMean,
              Steady([&isa = isa](const Cell& cell) {
                return IsOf(cell, "triangles", isa) && IsMainKind(cell) && IsPicture(cell);
              }));
    }
  }

  void Geometries() {
    Samples samples;
    for (const CellResult& result : results_.cells) {
      const Cell& cell = result.cell;
      if (cell.geometry == "triangles" || cell.geometry == "compact" || !IsPicture(cell)) continue;
      samples.push_back({result.SteadyRatio(), Name(cell), cell.geometry});
    }
    AtLeast(1.3, "other kinds of geometry, from 64K rays", kMean, samples);
    AtLeast(1.0, "each of these kinds", kWorstGroup, samples);
  }

  void Compact() {
    const auto is_compact = [this](const Cell& cell) { return IsOf(cell, "compact", best_isa_); };
    AtLeast(1.0, "COMPACT against COMPACT, from 64K rays", kMean,
            Steady([&](const Cell& cell) { return is_compact(cell) && IsPicture(cell); }));
    AtLeast(0.6, "COMPACT against COMPACT, 64 rays a call", kMean,
            Steady([&](const Cell& cell) { return is_compact(cell) && cell.size == "64"; }));
  }

  // The drop-in's time on one thread over that on two.
  void Threads() {
    Samples samples;
    for (const CellResult& one : results_.cells) {
      if (one.cell.threads != 1 || SizeOf(one.cell).rays < kMillionRays) continue;
      Cell on_two = one.cell;
      on_two.threads = 2;
      const auto two = std::ranges::find(results_.cells, on_two, &CellResult::cell);
      if (two == results_.cells.end()) continue;
      samples.push_back({one.dacrt.Steady() / two->dacrt.Steady(), Name(on_two), ""});
    }
    AtLeast(1.85, "2 threads against 1, from 1M rays", kMean, samples);
  }

  void Memory() {
    Samples kept, compact, peak;
    for (const MemoryResult& result : results_.memory) {
      const std::string name = Name(result.cell);
      const MemoryUse& use = result.dacrt;
      const double triangles = result.triangles;
      const bool is_compact = result.cell.geometry == "compact";
      if (triangles >= kLargeMesh) {
        const std::size_t workspaces = std::min(use.left_resident, use.kept_resident);
        Samples& of_its_kind = is_compact ? compact : kept;
        of_its_kind.push_back({(use.kept_resident - workspaces) / triangles, name, ""});
      }
      if (triangles >= kMillionTriangles && !is_compact) {
        const double ratio = static_cast<double>(use.peak_resident) / result.embree.peak_resident;
        peak.push_back({ratio, name, ""});
      }
    }
    AtMost(32, "kept beside the workspaces, bytes a triangle, from 250K", kept);
    AtMost(8, "kept in a COMPACT scene, beside the workspaces", compact);
    AtMost(1.0 / 3, "peak over Embree's, from 1M triangles", peak);
  }

 private:
  static constexpr Judged kMean = Judged::kGeometricMean;
  static constexpr Judged kWorstGroup = Judged::kWorstMean;
  static constexpr Judged kWorst = Judged::kWorstCell;

  bool IsTriangles(const Cell& cell) const { return IsOf(cell, "triangles", best_isa_); }

  bool IsPlain(const Cell& cell) const { return IsTriangles(cell) && IsMainKind(cell); }

  template <class IsMeant>
  Samples Steady(const IsMeant& is_meant) const {
    Samples samples;
    for (const CellResult& result : results_.cells) {
      if (result.triangles < kSmallScene || !is_meant(result.cell)) continue;
      samples.push_back({result.SteadyRatio(), Name(result.cell), ""});
    }
    return samples;
  }

  void AtLeast(double goal, const std::string& figure, Judged judged, const Samples& samples) {
    goals_.push_back(Judge(figure, judged, Bound::kAtLeast, goal, samples));
  }

  void AtMost(double goal, const std::string& figure, const Samples& samples) {
    goals_.push_back(Judge(figure, kWorst, Bound::kAtMost, goal, samples));
  }

  const EmbreeResults& results_;
  const std::string best_isa_ = IsasHere().front();
  std::vector<Goal> goals_;
};

}  // namespace

std::vector<Goal> JudgeGoals(const EmbreeResults& results) {
  Figures figures(results);
  figures.SteadyPictures();
  figures.SteadySlices();
  figures.Calls();
  figures.LargestBatch();
  figures.OtherIsas();
  figures.Geometries();
  figures.Compact();
  figures.Threads();
  figures.Memory();
  figures.OneShot();
  return figures.goals();
}

}  // namespace dacrt::bench
