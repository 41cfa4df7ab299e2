// Which of two hits of a ray is nearer.
#pragma once

namespace dacrt {

enum class Closeness { kFarther, kEqual, kCloser };

/// Whether a hit at `t` may replace what a ray has: a hit at `tfar`, or nothing within its own
/// tfar, which is `tfar` as long as the ray is `at_limit`. `within_limit` says that the hit passes
/// Embree's test against tfar. Where it is as far away as a hit that the ray has, names decide.
inline Closeness CompareHits(float t, bool within_limit, float tfar, bool at_limit, bool has_hit) {
  if (t < tfar) return Closeness::kCloser;
  // At the ray's own tfar, t may have rounded to a larger number.
  if (!(at_limit ? within_limit : t == tfar)) return Closeness::kFarther;
  return has_hit ? Closeness::kEqual : Closeness::kCloser;
}

}  // namespace dacrt
