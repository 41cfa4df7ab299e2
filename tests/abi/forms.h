// Calls in every form of a query.
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "session.h"
#include "streams.h"

namespace dacrt::tests {

/// Every way to call rtcIntersect* and rtcOccluded*.
std::vector<Form> AllForms();

/// Runs `body(form, query)` for every form and query, until a test fails.
template <class Body>
void ForEachCall(const Body& body) {
  for (const Form& form : AllForms()) {
    for (const Query query : {Query::kClosest, Query::kAny}) {
      SCOPED_TRACE(Name(form) + ", " + Name(query));
      body(form, query);
      if (testing::Test::HasFailure()) return;
    }
  }
}

/// A row of rays along +z, from z = -10, through the unit square. Some miss it, and one is
/// inactive. IDs, flags and masks differ, as far as `form` can carry them, and hits hold what they
/// did before.
inline constexpr int kRays = 40;
std::vector<RTCRayHit> RowOfRays(const Form& form = {});
bool MeetsSquare(int number);

/// Makes `ray` the one in this lane of a packet. Embree's headers have no function for that.
void SetLane(RTCRayN* rays, unsigned int lanes, unsigned int lane, const RTCRay& ray);

/// The number in the row of the ray that starts at this x.
int NumberOf(float org_x);

/// Traces packets of 4, 8 and 16 rays that meet the square, with their lanes for IDs, of which
/// every third is valid; both queries. Returns how many valid rays there are. See HasPacketsOf16.
std::size_t TraceThirdsOfPackets(const Session& s, RTCScene scene, RTCIntersectContext& context);

/// Traces a copy of `rays`, as the function of streams.h does.
std::vector<RTCRayHit> Trace(const Api& api, RTCScene scene, RTCIntersectContext& context,
                             const Form& form, Query query, std::span<const RTCRayHit> rays);

/// Nothing but rounding differs. Normals of spheres inherit that of the distance t.
void ExpectSameHit(const RTCHit& ours, const RTCHit& real, float t);
void ExpectSameRays(std::span<const RTCRayHit> ours, std::span<const RTCRayHit> real);

bool AreSame(const RTCRayHit& a, const RTCRayHit& b);

}  // namespace dacrt::tests
