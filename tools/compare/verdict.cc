#include "verdict.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "format.h"
#include "timing.h"

namespace dacrt::compare {
namespace {

bool Gains(double ratio) { return ratio > 1 + kEven; }
bool Loses(double ratio) { return ratio < 1 / (1 + kEven); }

std::string Times(double ratio) {
  return bench::Fixed(ratio >= 1 ? ratio : 1 / ratio, 2) +
         (ratio >= 1 ? " times as fast" : " times as slow");
}

/// The parts for which `is_of` holds, those first that matter most: by the time between the two, or
/// where the parts are not of one work by their ratio.
template <class Predicate>
std::string List(std::vector<Compared> parts, bool is_one_work, const Predicate& is_of) {
  constexpr std::size_t kMost = 6;
  std::erase_if(parts, [&](const Compared& part) { return !is_of(part.Ratio()); });
  std::ranges::sort(parts, std::ranges::greater(), [&](const Compared& part) {
    return is_one_work ? std::abs(part.embree - part.dacrt) : std::abs(std::log(part.Ratio()));
  });
  std::string list;
  for (const Compared& part : std::span(parts).first(std::min(parts.size(), kMost))) {
    list += (list.empty() ? "" : "; ") + part.what + " (" + Times(part.Ratio()) + ")";
  }
  if (parts.size() > kMost) list += "; and " + std::to_string(parts.size() - kMost) + " more";
  return list.empty() ? "nowhere by more than a tenth" : list;
}

template <class Predicate>
double LossOf(const std::vector<Compared>& parts, const Predicate& is_of) {
  double loss = 0;
  for (const Compared& part : parts) {
    if (is_of(part) && Loses(part.Ratio())) loss += part.dacrt - part.embree;
  }
  return loss;
}

bool IsTraced(const Compared& part) {
  return part.kind == Kind::kClosest || part.kind == Kind::kAny;
}

void AddAdvice(const std::vector<Compared>& parts, const Peaks& peaks,
               std::vector<std::string>& lines) {
  const auto is_small = [](const Compared& part) {
    return IsTraced(part) && part.form <= Form::kPacket;
  };
  const auto is_short_stream = [](const Compared& part) {
    return IsTraced(part) && (part.form == Form::kTo64 || part.form == Form::kTo1K);
  };
  if (LossOf(parts, is_small) > 0) {
    lines.push_back(
        "set: send rays thousands a call (rtcIntersect1M, rtcOccluded1M): dacrt is made for that, "
        "and "
        "not for single rays and packets");
  }
  if (LossOf(parts, is_short_stream) > 0) {
    lines.push_back("set: collect more rays for a call: some thousands, better 64K");
  }
  // Workspaces of the threads are no burden that a budget could ease.
  constexpr double kMuch = 1.1, kWorkspaces = 32e6;
  const double more = static_cast<double>(peaks.dacrt) - static_cast<double>(peaks.embree);
  if (peaks.embree > 0 &&
      static_cast<double>(peaks.dacrt) > kMuch * static_cast<double>(peaks.embree) &&
      more > kWorkspaces) {
    lines.push_back(
        "set: RTC_SCENE_FLAG_COMPACT, or DACRT_CONFIG=dacrt_budget=BYTES for each scene, for less "
        "memory");
  }
  if (std::ranges::any_of(
          parts, [](const Compared& part) { return IsTraced(part) && part.form >= Form::kTo4K; })) {
    lines.push_back(
        "know: dacrt works on a stream with all threads of the machine; DACRT_CONFIG=threads=N "
        "limits it");
  }
}

std::string Decision(const std::string& of, double ratio) {
  if (Gains(ratio)) return "verdict: switch: " + of + ", dacrt is " + Times(ratio);
  if (Loses(ratio)) {
    return "verdict: stay, or change how rays are sent: " + of + ", dacrt is " + Times(ratio);
  }
  return "verdict: about even: " + of + ", Embree's time is " + bench::Fixed(ratio, 2) +
         " of dacrt's";
}

}  // namespace

std::string NameOf(Kind kind, Form form) {
  const std::string kinds[] = {"closest hit", "any hit", "point query", "commit"};
  std::string name = kinds[static_cast<std::size_t>(kind)];
  if (kind == Kind::kCommit) return name;
  const bool are_rays = kind != Kind::kPoint;
  const std::string singles = are_rays ? "single rays" : "single points";
  const std::string forms[] = {singles,         "packets",          "streams to 64",
                               "streams to 1K", "streams to 4K",    "streams to 64K",
                               "streams to 1M", "streams beyond 1M"};
  return name + ", " + forms[static_cast<std::size_t>(form)];
}

std::vector<std::string> Verdict(const std::vector<Compared>& parts, const Compared* total,
                                 const Peaks& peaks) {
  std::vector<std::string> lines;
  if (total) {
    lines.push_back(Decision(total->what, total->Ratio()));
  } else {
    for (const bool is_first : {true, false}) {
      std::vector<double> ratios;
      for (const Compared& part : parts) {
        if ((part.kind == Kind::kCommit) == is_first) ratios.push_back(part.Ratio());
      }
      if (ratios.empty()) continue;
      lines.push_back(Decision(is_first ? "on scenes that are new in each frame (first passes)"
                                        : "on scenes that stay as they are (later passes)",
                               bench::GeometricMean(ratios)));
    }
  }
  lines.push_back("gains: " + List(parts, total != nullptr, Gains));
  lines.push_back("loses: " + List(parts, total != nullptr, Loses));
  AddAdvice(parts, peaks, lines);
  return lines;
}

}  // namespace dacrt::compare
