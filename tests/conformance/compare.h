// Two libraries' answers to one ray: the same, different for a reason that the reference proves, or
// different without one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "company.h"
#include "reference.h"
#include "streams.h"

namespace dacrt::tests {

/// How the drop-in's answer relates to the real library's. All but kUnexplained are allowed: the
/// reference has shown that both answers are what a correct single-precision computation may give.
enum class Relation {
  kIdentical,       ///< the same bits in the whole record
  kRounding,        ///< the same triangle, values within 16 ulp of 1.0 relative to their scale
  kTie,             ///< another triangle within 2 ulp in distance, and both are closest
  kEdge,            ///< one passes the edge of a triangle that the other hits
  kInterval,        ///< a hit at tnear or tfar, counted by one
  kParallel,        ///< a triangle that is parallel to the ray, hit by one
  kIllConditioned,  ///< values, or an order of hits, that rounding leaves open by more than 16 ulp
  kSlabTest,        ///< the real library's bounding-box test loses a hit
  kWithheld,        ///< a ray that the real library aborts on; the drop-in is judged alone
  kRange,           ///< a product is beyond the range of single precision
  kUnexplained,
};
inline constexpr int kRelationCount = 11;

const char* Name(Relation relation);

/// Which library exact arithmetic sides with.
enum class Side { kNeither, kReal, kDropIn, kBoth };
inline constexpr int kSideCount = 4;

const char* Name(Side side);

struct Comparison {
  Relation relation = Relation::kIdentical;
  Side right = Side::kBoth;  ///< of differences that the reference was asked about
  std::string reason;        ///< of kUnexplained
};

/// Whether Debian's Embree, which is built with assertions, ends the process over such a ray: one
/// that is not a number somewhere, that has an origin or direction beyond 1.844e18, or a negative
/// tnear.
bool RealLibraryAborts(const RTCRay& ray);

/// Whether a ray is inactive or not finite, so that no byte of its record may change.
bool FindsNothing(const RTCRay& ray);

class Comparer {
 public:
  /// `scene` must outlive the comparer.
  explicit Comparer(const TestScene& scene) : reference_(scene) {}

  /// `before` is the record that both libraries were given, the others are what they made of it.
  /// The real library must not abort on it.
  Comparison Compare(Query query, const RTCRayHit& before, const RTCRayHit& real,
                     const RTCRayHit& drop_in, const Company& company = {}) const;

  /// Why `after` cannot be right, whatever another library says; nothing if it can.
  std::optional<std::string> FindFault(Query query, const RTCRayHit& before,
                                       const RTCRayHit& after) const;

  /// Ray, answers and what the reference knows of them, in several lines. `real` is null if the
  /// real library was not asked.
  std::string Describe(Query query, const RTCRayHit& before, const RTCRayHit* real,
                       const RTCRayHit& drop_in) const;

 private:
  Reference reference_;
};

}  // namespace dacrt::tests
