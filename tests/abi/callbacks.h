// Callbacks that note what they are called with, and answer as a test wants it.
#pragma once

#include <compare>
#include <functional>
#include <set>
#include <vector>

#include "forms.h"
#include "session.h"

namespace dacrt::tests {

/// A hit that a filter function is asked about. Rays have their numbers in the row.
struct Offer {
  int ray;
  float t;
  RTCHit hit;
};

/// What a filter function answers: whether it accepts the hit, which it may have changed.
using Judge = std::function<bool(Offer&)>;
bool Accept(Offer&);
bool Reject(Offer&);

/// A ray that a user function is called for.
struct Visit {
  int ray;
  unsigned int geometry, primitive, instance;
  auto operator<=>(const Visit&) const = default;
};

/// What is left of a call.
struct Outcome {
  std::vector<RTCRayHit> rays;
  std::vector<Offer> offers, context_offers;
  std::vector<Visit> visits;
  std::set<unsigned int> filter_widths, user_widths;  ///< N of all calls
  std::set<unsigned int> rays_a_visit;                ///< valid lanes of user functions' calls
  int idle_calls = 0;                                 ///< of any function, without valid lanes
};

/// Traces the first `count` rays of the row. A context filter is set if it has a judge.
Outcome TraceRow(Session& s, RTCScene scene, const Form& form, Query query, const Judge& geometry,
                 const Judge& context = nullptr, int count = kRays);

/// The filter functions for calls of TraceRow. The geometry must have user data.
void FilterOfGeometry(const RTCFilterFunctionNArguments* args);
void FilterOfContext(const RTCFilterFunctionNArguments* args);

/// A user geometry, for calls of TraceRow: the unit squares at z = 0, 1, 2 and so on.
struct Squares {
  const Api& api;
  unsigned int count;
  bool asks_filters = false;  ///< by rtcFilterIntersection and rtcFilterOcclusion
  bool is_hit = true;
};

/// It refers to `squares`. Committed, with filter functions.
RTCGeometry NewSquares(Session& s, Squares& squares);

/// The geometry in the scene that was traced; of an instance, the instance.
unsigned int TopId(const RTCHit& hit);

/// Nothing but rounding and the order differs.
void ExpectSameOffers(std::vector<Offer> ours, std::vector<Offer> real);

}  // namespace dacrt::tests
