// rtcore_geometry.h: instances and their transforms.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"
#include "scene.h"
#include "transform_format.h"

using namespace dacrt::compat;

RTC_API void rtcSetGeometryInstancedScene(RTCGeometry hgeometry, RTCScene hscene) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetInstancedScene(Resolve(hscene, "scene")); });
}

RTC_API void rtcSetGeometryTransform(RTCGeometry hgeometry, unsigned int timeStep, RTCFormat format,
                                     const void* xfm) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) {
    CheckPointer(xfm, "xfm");
    geometry.SetTransform(timeStep, ReadTransform(format, static_cast<const float*>(xfm)));
  });
}

RTC_API void rtcSetGeometryTransformQuaternion(RTCGeometry hgeometry, unsigned int timeStep,
                                               const RTCQuaternionDecomposition* qd) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) {
    CheckPointer(qd, "qd");
    geometry.SetTransform(timeStep, ReadTransform(*qd));
  });
}

RTC_API void rtcGetGeometryTransform(RTCGeometry hgeometry, float time, RTCFormat format,
                                     void* xfm) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) {
    const dacrt::AffineTransform transform = geometry.TransformAt(time);
    CheckPointer(xfm, "xfm");
    WriteTransform(transform, format, static_cast<float*>(xfm));
  });
}
