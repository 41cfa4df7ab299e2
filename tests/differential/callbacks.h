// The functions that a world's geometries are called back with, the same for both libraries, and
// what they note of a call.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <string>
#include <vector>

#include "embree_api.h"
#include "world.h"

namespace dacrt::tests {

/// A candidate hit that a filter function was shown.
struct Offer {
  uint32_t ray_id;
  RTCHit hit;
  float t;
  bool by_context;  ///< shown to the context's filter function, else to the geometry's
};

/// The context of a call with what callbacks need and note; Embree hands on the pointer to its
/// first member.
struct CallContext {
  RTCIntersectContext context;
  FilterKind context_filter = FilterKind::kNone;
  std::vector<Offer> offers;
  uint32_t fewest_lanes = UINT32_MAX;  ///< N of the calls of filter functions by the library
  bool in_user_function = false;       ///< the filter function was called by way of rtcFilter...
  std::string fault;                   ///< a broken promise of the library; empty if there is none
};

/// A context for calls whose context filter function, if any, is of this kind.
CallContext MakeContext(FilterKind context_filter);

/// What the user pointer of a geometry points to.
struct GeometryData {
  const EmbreeApi* api = nullptr;
  const WorldGeometry* geometry = nullptr;
  RTCScene traced_again = nullptr;  ///< user functions trace their rays in it as well
};

void FilterClosest(const RTCFilterFunctionNArguments* arguments);
void FilterAny(const RTCFilterFunctionNArguments* arguments);

/// User geometries: spheres that are tested in double precision.
void BoundUserPrimitive(const RTCBoundsFunctionArguments* arguments);
void IntersectUserPrimitive(const RTCIntersectFunctionNArguments* arguments);
void OccludeUserPrimitive(const RTCOccludedFunctionNArguments* arguments);

}  // namespace dacrt::tests
