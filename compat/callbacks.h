// The program's functions of a geometry, and the adapters through which the engine calls them.
#pragma once

#include <embree3/rtcore.h>

#include "dacrt/callback.h"
#include "dacrt/geometry.h"

namespace dacrt::compat {

class Geometry;

struct GeometryCallbacks {
  RTCFilterFunctionN closest_filter = nullptr;
  RTCFilterFunctionN any_filter = nullptr;
  RTCBoundsFunction bounds = nullptr;
  RTCIntersectFunctionN intersect = nullptr;
  RTCOccludedFunctionN occluded = nullptr;
  RTCPointQueryFunction point_query = nullptr;
};

/// Makes the engine call the functions of `geometry`. Whether a query looks for filter functions is
/// decided now, which they are when they are called: as in Embree, where a commit chooses the code,
/// if for both queries at once.
/// CallOptions::call must be the RTCIntersectContext of the call. `context_filter` says that the
/// context's filter function counts, too.
void SetCallbacks(Geometry& geometry, bool context_filter, dacrt::Geometry& description);

/// What rtcFilterIntersection and rtcFilterOcclusion do: run the filter functions for what an
/// intersect or occluded function found. `args` is what that function was called with.
void FilterFromUserFunction(const RTCIntersectFunctionNArguments& args,
                            const RTCFilterFunctionNArguments& filter_args);
void FilterFromUserFunction(const RTCOccludedFunctionNArguments& args,
                            const RTCFilterFunctionNArguments& filter_args);

}  // namespace dacrt::compat
