// What is exported, because programs are linked against it, and not supported. Handles are checked
// as in Embree; then each function reports RTC_ERROR_INVALID_OPERATION.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"
#include "scene.h"

using namespace dacrt::compat;

// Exported by Embree, in none of its headers.
extern "C" __attribute__((visibility("default"))) void rtcMakeStaticBVH(RTCBVH hbvh);

namespace {

constexpr const char* kCurveWidths = "minimal widths of curves and points";
constexpr const char* kSubdivision = "subdivision surfaces";
constexpr const char* kCollisions = "collisions";
constexpr const char* kBuilder = "the building of a BVH";

[[noreturn]] void Refuse(const char* feature) {
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "dacrt does not support ", feature);
}

/// Reports that `feature` is not supported, to the device of `handle`, its argument `name`.
template <class Handle>
void RefuseOn(const char* function, Handle handle, const char* name, const char* feature) {
  OnObject(function, handle, name, [&](auto&) { Refuse(feature); });
}

/// The same for a function of the builder that has no handle but `pointer`, its argument `name`.
/// There is no device then that the error could go to.
void RefusePointer(const char* function, const void* pointer, const char* name) {
  Guarded(function, nullptr, [&] {
    CheckPointer(pointer, name);
    Refuse(kBuilder);
  });
}

/// What Embree's functions about half edges return when they fail.
constexpr unsigned int kNoHalfEdge = static_cast<unsigned int>(-1);

}  // namespace

// rtcore_geometry.h: curves and subdivision surfaces

RTC_API void rtcSetGeometryMaxRadiusScale(RTCGeometry hgeometry, float) {
  // Embree refuses it too, as Debian builds it.
  RefuseOn(__func__, hgeometry, "geometry", kCurveWidths);
}

RTC_API void rtcSetGeometryTessellationRate(RTCGeometry hgeometry, float) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
}

RTC_API void rtcSetGeometryTopologyCount(RTCGeometry hgeometry, unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
}

RTC_API void rtcSetGeometrySubdivisionMode(RTCGeometry hgeometry, unsigned int,
                                           RTCSubdivisionMode) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
}

RTC_API void rtcSetGeometryVertexAttributeTopology(RTCGeometry hgeometry, unsigned int,
                                                   unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
}

RTC_API void rtcSetGeometryDisplacementFunction(RTCGeometry hgeometry, RTCDisplacementFunctionN) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
}

RTC_API unsigned int rtcGetGeometryFirstHalfEdge(RTCGeometry hgeometry, unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
  return kNoHalfEdge;
}

RTC_API unsigned int rtcGetGeometryFace(RTCGeometry hgeometry, unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
  return kNoHalfEdge;
}

RTC_API unsigned int rtcGetGeometryNextHalfEdge(RTCGeometry hgeometry, unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
  return kNoHalfEdge;
}

RTC_API unsigned int rtcGetGeometryPreviousHalfEdge(RTCGeometry hgeometry, unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
  return kNoHalfEdge;
}

RTC_API unsigned int rtcGetGeometryOppositeHalfEdge(RTCGeometry hgeometry, unsigned int,
                                                    unsigned int) {
  RefuseOn(__func__, hgeometry, "geometry", kSubdivision);
  return kNoHalfEdge;
}

// rtcore_scene.h: collisions

RTC_API void rtcCollide(RTCScene hscene0, RTCScene, RTCCollideFunc, void*) {
  RefuseOn(__func__, hscene0, "scene0", kCollisions);
}

// rtcore_builder.h. As there is never a BVH, no handle of one is alive.

RTC_API RTCBVH rtcNewBVH(RTCDevice hdevice) {
  RefuseOn(__func__, hdevice, "device", kBuilder);
  return nullptr;
}

RTC_API void* rtcBuildBVH(const RTCBuildArguments* args) {
  RefusePointer(__func__, args, "args");
  return nullptr;
}

RTC_API void* rtcThreadLocalAlloc(RTCThreadLocalAllocator allocator, size_t, size_t) {
  RefusePointer(__func__, allocator, "allocator");
  return nullptr;
}

RTC_API void rtcRetainBVH(RTCBVH hbvh) { RefusePointer(__func__, hbvh, "bvh"); }

RTC_API void rtcReleaseBVH(RTCBVH hbvh) { RefusePointer(__func__, hbvh, "bvh"); }

void rtcMakeStaticBVH(RTCBVH hbvh) { RefusePointer(__func__, hbvh, "bvh"); }
