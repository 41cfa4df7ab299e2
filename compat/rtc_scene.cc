// rtcore_scene.h but for the queries.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"
#include "scene.h"

using namespace dacrt::compat;

RTC_API RTCScene rtcNewScene(RTCDevice hdevice) {
  return NewHandle<RTCScene>(__func__, hdevice, [&](Device& device) {
    return std::make_shared<Scene>(device.shared_from_this());
  });
}

RTC_API RTCDevice rtcGetSceneDevice(RTCScene hscene) {
  RTCDevice device = nullptr;
  OnObject(__func__, hscene, "scene", [&](Scene& scene) {
    HandleTable<Device>::Instance().Retain(scene.device());
    device = ToHandle(scene.device().get());
  });
  return device;
}

RTC_API void rtcRetainScene(RTCScene hscene) { RetainHandle(__func__, hscene, "scene"); }

RTC_API void rtcReleaseScene(RTCScene hscene) { ReleaseHandle(__func__, hscene, "scene"); }

RTC_API unsigned int rtcAttachGeometry(RTCScene hscene, RTCGeometry hgeometry) {
  unsigned int id = RTC_INVALID_GEOMETRY_ID;
  OnObject(__func__, hscene, "scene",
           [&](Scene& scene) { id = scene.Attach(Resolve(hgeometry, "geometry")); });
  return id;
}

RTC_API void rtcAttachGeometryByID(RTCScene hscene, RTCGeometry hgeometry, unsigned int geomID) {
  OnObject(__func__, hscene, "scene",
           [&](Scene& scene) { scene.AttachById(Resolve(hgeometry, "geometry"), geomID); });
}

RTC_API void rtcDetachGeometry(RTCScene hscene, unsigned int geomID) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) { scene.Detach(geomID); });
}

// Programs call this once a hit, so the handle is trusted, as in a query.
RTC_API RTCGeometry rtcGetGeometry(RTCScene hscene, unsigned int geomID) {
  RTCGeometry geometry = nullptr;
  Guarded(__func__, nullptr, [&] {
    CheckPointer(hscene, "scene");
    geometry = ToHandle(ToObject(hscene)->Find(geomID));
  });
  return geometry;
}

RTC_API RTCGeometry rtcGetGeometryThreadSafe(RTCScene hscene, unsigned int geomID) {
  RTCGeometry geometry = nullptr;
  OnObject(__func__, hscene, "scene",
           [&](Scene& scene) { geometry = ToHandle(scene.FindThreadSafe(geomID)); });
  return geometry;
}

RTC_API void rtcCommitScene(RTCScene hscene) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) { scene.Commit(); });
}

RTC_API void rtcJoinCommitScene(RTCScene hscene) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) { scene.Commit(); });
}

RTC_API void rtcSetSceneProgressMonitorFunction(RTCScene hscene,
                                                RTCProgressMonitorFunction progress, void* ptr) {
  OnObject(__func__, hscene, "scene",
           [&](Scene& scene) { scene.SetProgressMonitor(progress, ptr); });
}

RTC_API void rtcSetSceneBuildQuality(RTCScene hscene, RTCBuildQuality quality) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) { scene.SetBuildQuality(quality); });
}

RTC_API void rtcSetSceneFlags(RTCScene hscene, RTCSceneFlags flags) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) { scene.set_flags(flags); });
}

RTC_API RTCSceneFlags rtcGetSceneFlags(RTCScene hscene) {
  RTCSceneFlags flags = RTC_SCENE_FLAG_NONE;
  OnObject(__func__, hscene, "scene", [&](Scene& scene) { flags = scene.flags(); });
  return flags;
}

RTC_API void rtcGetSceneBounds(RTCScene hscene, RTCBounds* bounds_o) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) {
    const RTCBounds bounds = scene.Bounds();
    if (!bounds_o) throw ApiError(RTC_ERROR_INVALID_OPERATION, "bounds_o is null");
    *bounds_o = bounds;
  });
}

RTC_API void rtcGetSceneLinearBounds(RTCScene hscene, RTCLinearBounds* bounds_o) {
  OnObject(__func__, hscene, "scene", [&](Scene& scene) {
    if (!bounds_o) throw ApiError(RTC_ERROR_INVALID_OPERATION, "bounds_o is null");
    *bounds_o = scene.LinearBounds();
  });
}
