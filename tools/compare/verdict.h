// What the figures mean for whoever thinks of switching.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "call_counts.h"

namespace dacrt::compare {

/// A kind of call with both libraries.
struct Compared {
  std::string what;  ///< as "closest hit, single rays"
  Kind kind;
  Form form;
  double embree, dacrt;  ///< seconds for the same work

  double Ratio() const { return embree / dacrt; }  ///< above 1 dacrt is faster
};

struct Peaks {
  std::size_t embree = 0, dacrt = 0;  ///< bytes; 0 where they are not known
};

/// Ratios within this of 1 are even: that is what runs on a machine differ by.
inline constexpr double kEven = 0.1;

/// Some lines: the verdict, where dacrt gains, where it loses, and what to do. `total` holds the
/// times of all of the work, where the parts add up to one. Where it is null, the parts are first
/// passes (those of Kind::kCommit) and later ones, and each ray of theirs counts the same.
std::vector<std::string> Verdict(const std::vector<Compared>& parts, const Compared* total,
                                 const Peaks& peaks);

/// As "closest hit, streams of up to 1,024 rays".
std::string NameOf(Kind kind, Form form);

}  // namespace dacrt::compare
