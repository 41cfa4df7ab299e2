// Two libraries' answers to one ray of a batch in a world, judged as in conformance/compare.h.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "callbacks.h"
#include "compare.h"
#include "slab_test.h"
#include "world_reference.h"

namespace dacrt::tests {

/// Whose answer is judged: the real library's bounding boxes may lose hits.
enum class Library { kReal, kDropIn };

const char* Name(Library library);

class WorldComparer {
 public:
  /// `scenes` must outlive the comparer and stay as they are.
  explicit WorldComparer(const std::vector<WorldScene>& scenes)
      : scenes_(scenes), reference_(scenes) {}

  /// As Comparer::Compare; `judged` is what `drop_in` is judged as.
  Comparison Compare(const Batch& batch, Library judged, const RTCRayHit& before,
                     const RTCRayHit& real, const RTCRayHit& drop_in, const Company& company) const;

  /// Why `after` cannot be right, whatever another library says; nothing if it can.
  std::optional<std::string> FindFault(const Batch& batch, Library library, const RTCRayHit& before,
                                       const RTCRayHit& after, const Company& company) const;

  /// Why the hits that filter functions were shown for one ray cannot be right: one that is none,
  /// one that was shown twice, or one that should have been shown and was not.
  std::optional<std::string> FindOfferFault(const Batch& batch, Library library,
                                            const RTCRayHit& before, const RTCRayHit& after,
                                            std::span<const Offer> offers,
                                            const Company& company) const;

  /// Ray, answers and what the reference knows of them, in several lines.
  std::string Describe(const Batch& batch, const RTCRayHit& before, const RTCRayHit& real,
                       const RTCRayHit& drop_in) const;

 private:
  /// The real library's kernels differ in what they do at and beyond the ends of a geometry's
  /// times.
  bool IsExcused(Library library, const RTCRayHit& before) const;

  const std::vector<WorldScene>& scenes_;
  WorldReference reference_;
};

}  // namespace dacrt::tests
