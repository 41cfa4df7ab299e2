// What a run of method_bench found, and its form as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "measure.h"

namespace dacrt::bench {

struct Results {
  std::string command;
  std::string processor;
  std::string instruction_set;
  int repeat = 0;
  std::vector<FrameResult> comparison;  ///< of the algorithms
  std::vector<FrameResult> ablation;    ///< the first method is the default
  std::vector<std::string> unreadable;  ///< scenes, with the reason
};

nlohmann::ordered_json ToJson(const Results& results);

/// A share of the time of a trace.
struct Stage {
  const char* name;
  double Statistics::*seconds;
};
inline constexpr Stage kStages[] = {
    {"loading", &Statistics::seconds_loading},     {"sampling", &Statistics::seconds_sampling},
    {"binning", &Statistics::seconds_binning},     {"partition", &Statistics::seconds_partition},
    {"filtering", &Statistics::seconds_filtering}, {"direct solve", &Statistics::seconds_direct},
    {"storing", &Statistics::seconds_storing}};

/// The time that no stage accounts for.
double RestOf(const Statistics& statistics, double seconds);

}  // namespace dacrt::bench
