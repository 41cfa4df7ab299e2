#include "goal.h"

#include <algorithm>
#include <map>

#include "format.h"
#include "timing.h"

namespace dacrt::bench {
namespace {

using Bound = Goal::Bound;
using Judged = Goal::Judged;

double MeanOf(const std::vector<GoalSample>& samples) {
  std::vector<double> values;
  for (const GoalSample& sample : samples) values.push_back(sample.value);
  return GeometricMean(values);
}

// One sample a group: its mean, under its name.
std::vector<GoalSample> MeansOfGroups(const std::vector<GoalSample>& samples) {
  std::map<std::string, std::vector<GoalSample>> groups;
  for (const GoalSample& sample : samples) groups[sample.group].push_back(sample);
  std::vector<GoalSample> means;
  for (const auto& [group, members] : groups) means.push_back({MeanOf(members), group, group});
  return means;
}

}  // namespace

const char* Name(Judged judged) {
  switch (judged) {
    case Judged::kGeometricMean:
      return "geometric mean";
    case Judged::kWorstMean:
      return "worst mean";
    case Judged::kWorstCell:
      return "worst cell";
  }
  return "";
}

bool Goal::IsMet() const {
  return measured && (bound == Bound::kAtLeast ? *measured >= goal : *measured <= goal);
}

Goal Judge(const std::string& figure, Judged judged, Bound bound, double goal,
           const std::vector<GoalSample>& samples) {
  Goal judgement{figure, judged, bound, goal, samples.size(), {}, {}};
  if (samples.empty()) return judgement;
  const std::vector<GoalSample> judged_samples =
      judged == Judged::kWorstMean ? MeansOfGroups(samples) : samples;
  const auto [least, most] = std::ranges::minmax_element(judged_samples, {}, &GoalSample::value);
  const GoalSample& worst = bound == Bound::kAtLeast ? *least : *most;
  judgement.measured = judged == Judged::kGeometricMean ? MeanOf(samples) : worst.value;
  judgement.worst = worst.cell;
  return judgement;
}

Table GoalsTable(const std::vector<Goal>& goals) {
  constexpr std::size_t kLeft = 2;
  Table table({"figure", "judged by", "cells", "goal", "measured", "", "worst"}, kLeft);
  for (const Goal& goal : goals) {
    const bool is_least = goal.bound == Bound::kAtLeast;
    table.Add({goal.figure, Name(goal.judged), Grouped(goal.cells),
               (is_least ? "at least " : "at most ") + Significant(goal.goal),
               goal.measured ? Significant(*goal.measured) : "",
               !goal.measured ? "not measured"
               : goal.IsMet() ? "met"
                              : "missed",
               goal.worst});
  }
  return table;
}

}  // namespace dacrt::bench
