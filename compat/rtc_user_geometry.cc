// rtcore_geometry.h: user geometries, and the filter functions that they call.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "callbacks.h"
#include "device.h"
#include "geometry.h"

using namespace dacrt::compat;

RTC_API void rtcSetGeometryUserPrimitiveCount(RTCGeometry hgeometry,
                                              unsigned int userPrimitiveCount) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetUserPrimitiveCount(userPrimitiveCount); });
}

// As in Embree, a bounds function is called with the geometry's user data, not with a pointer of
// its own.
RTC_API void rtcSetGeometryBoundsFunction(RTCGeometry hgeometry, RTCBoundsFunction bounds, void*) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetBoundsFunction(bounds); });
}

RTC_API void rtcSetGeometryIntersectFunction(RTCGeometry hgeometry,
                                             RTCIntersectFunctionN intersect) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetIntersectFunction(intersect); });
}

RTC_API void rtcSetGeometryOccludedFunction(RTCGeometry hgeometry, RTCOccludedFunctionN occluded) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetOccludedFunction(occluded); });
}

RTC_API void rtcFilterIntersection(const RTCIntersectFunctionNArguments* args,
                                   const RTCFilterFunctionNArguments* filterArgs) {
  Guarded(__func__, nullptr, [&] {
    CheckPointer(args, "args");
    CheckPointer(filterArgs, "filterArgs");
    FilterFromUserFunction(*args, *filterArgs);
  });
}

RTC_API void rtcFilterOcclusion(const RTCOccludedFunctionNArguments* args,
                                const RTCFilterFunctionNArguments* filterArgs) {
  Guarded(__func__, nullptr, [&] {
    CheckPointer(args, "args");
    CheckPointer(filterArgs, "filterArgs");
    FilterFromUserFunction(*args, *filterArgs);
  });
}
