#include "goals.h"

#include <algorithm>
#include <functional>

#include "batch_size.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

using Bound = Goal::Bound;
using Judged = Goal::Judged;

// One cell's share in a figure.
struct Sample {
  double value;
  const Cell* cell;
};

constexpr std::size_t kMillionTriangles = 1'000'000;
constexpr std::size_t kMillionRays = 1 << 20;

std::size_t SizeOf(const Cell& cell) { return FindBatchSize(cell.size)->rays; }

// `value` of every result that `is_meant` takes.
template <class Result, class IsMeant, class Value>
std::vector<Sample> Samples(const std::vector<Result>& results, const IsMeant& is_meant,
                            const Value& value) {
  std::vector<Sample> samples;
  for (const Result& result : results) {
    if (is_meant(result)) samples.push_back({value(result), &result.cell});
  }
  return samples;
}

// The drop-in's time on one thread over that on two.
std::vector<Sample> Speedups(const std::vector<CellResult>& cells) {
  std::vector<Sample> samples;
  for (const CellResult& one : cells) {
    if (one.cell.threads != 1 || SizeOf(one.cell) < kMillionRays) continue;
    Cell on_two = one.cell;
    on_two.threads = 2;
    const auto two = std::ranges::find(cells, on_two, &CellResult::cell);
    if (two == cells.end()) continue;
    samples.push_back({one.dacrt.Steady() / two->dacrt.Steady(), &two->cell});
  }
  return samples;
}

double GeometricMeanOf(const std::vector<Sample>& samples) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(sample.value);
  return GeometricMean(values);
}

Goal JudgeSamples(const std::string& figure, Judged judged, Bound bound, double goal,
                  const std::vector<Sample>& samples) {
  Goal judgement{figure, judged, bound, goal, samples.size(), {}, {}};
  if (samples.empty()) return judgement;
  const auto [least, most] = std::ranges::minmax_element(samples, {}, &Sample::value);
  const Sample& worst = bound == Bound::kAtLeast ? *least : *most;
  judgement.measured = judged == Judged::kWorstCell ? worst.value : GeometricMeanOf(samples);
  judgement.worst_cell = Name(*worst.cell);
  return judgement;
}

}  // namespace

bool Goal::IsMet() const {
  return measured && (bound == Bound::kAtLeast ? *measured >= goal : *measured <= goal);
}

std::vector<Goal> JudgeGoals(const EmbreeResults& results) {
  std::vector<Goal> goals;
  const auto at_least = [&](double goal, const char* figure, Judged judged,
                            const std::vector<Sample>& samples) {
    goals.push_back(JudgeSamples(figure, judged, Bound::kAtLeast, goal, samples));
  };
  const auto at_most = [&](double goal, const char* figure, const std::vector<Sample>& samples) {
    goals.push_back(JudgeSamples(figure, Judged::kWorstCell, Bound::kAtMost, goal, samples));
  };
  constexpr Judged kMean = Judged::kGeometricMean;
  constexpr Judged kWorst = Judged::kWorstCell;

  const auto one_shot = [&](const auto& is_meant) {
    return Samples(results.cells, is_meant, std::mem_fn(&CellResult::OneShotRatio));
  };
  const auto steady = [&](const auto& is_meant) {
    return Samples(results.cells, is_meant, std::mem_fn(&CellResult::SteadyRatio));
  };
  const auto is_any = [](const CellResult&) { return true; };
  const auto is_picture = [](const CellResult& result) {
    return SizeOf(result.cell) >= BatchSize::kLeastPictureRays;
  };
  const auto is_4k = [](const CellResult& result) { return result.cell.size == "4K"; };
  const auto is_64 = [](const CellResult& result) { return result.cell.size == "64"; };
  const auto is_16m_diffuse = [](const CellResult& result) {
    return result.cell.size == "16M" && result.cell.kind == "diffuse";
  };
  at_least(2.5, "one shot, from 64K rays", kMean, one_shot(is_picture));
  at_least(1.0, "one shot", kWorst, one_shot(is_any));
  at_least(1.5, "steady, from 64K rays", kMean, steady(is_picture));
  at_least(1.0, "steady, from 64K rays", kWorst, steady(is_picture));
  at_least(0.8, "steady, 4,096 rays a call", kMean, steady(is_4k));
  at_least(0.8, "steady, 4,096 rays a call", kWorst, steady(is_4k));
  at_least(0.4, "steady, 64 rays a call", kMean, steady(is_64));
  at_least(0.4, "steady, 64 rays a call", kWorst, steady(is_64));
  at_least(2.5, "16M diffuse rays, trace against trace", kMean, steady(is_16m_diffuse));
  at_least(2.5, "16M diffuse rays, trace against trace", kWorst, steady(is_16m_diffuse));

  const auto speedups = Speedups(results.cells);
  at_least(1.8, "2 threads against 1, from 1M rays", kMean, speedups);
  at_least(1.8, "2 threads against 1, from 1M rays", kWorst, speedups);

  const auto is_any_memory = [](const MemoryResult&) { return true; };
  const auto is_large_scene = [](const MemoryResult& result) {
    return result.triangles >= kMillionTriangles && SizeOf(result.cell) <= kMillionRays;
  };
  const auto kept_a_triangle = [](const MemoryResult& result) {
    return static_cast<double>(result.dacrt.kept_resident) / result.triangles;
  };
  const auto peak_ratio = [](const MemoryResult& result) {
    return static_cast<double>(result.dacrt.peak_resident) / result.embree.peak_resident;
  };
  at_most(8, "kept between calls, bytes a triangle",
          Samples(results.memory, is_any_memory, kept_a_triangle));
  at_most(0.25, "peak over Embree's, from 1M triangles, up to 1M rays",
          Samples(results.memory, is_large_scene, peak_ratio));
  return goals;
}

}  // namespace dacrt::bench
