// rtcore_scene.h, point queries; rtcore_geometry.h, the function that they call. As in Embree the
// queries trust the scene's handle.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"
#include "point_query.h"
#include "scene.h"

using namespace dacrt::compat;

namespace {

/// Calls `run(scene)` with what the last commit made of the scene, and returns its answer; false if
/// it fails. `query` is the argument of that name.
template <class Run>
bool OnCommitted(const char* function, RTCScene hscene, const void* query,
                 RTCPointQueryContext* context, Run&& run) {
  const Scene* const scene = ToObject(hscene);
  bool changed = false;
  Guarded(function, scene ? scene->device().get() : nullptr, [&] {
    CheckPointer(scene, "scene");
    const dacrt::Scene& committed = scene->Committed();
    CheckPointer(query, "query");
    CheckPointer(context, "context");
    changed = run(committed);
  });
  return changed;
}

/// The valid lanes of a packet, one after the other.
template <int kLanes, class Packet>
bool QueryLanes(const char* function, const int* valid, RTCScene hscene, Packet* packet,
                RTCPointQueryContext* context, RTCPointQueryFunction query_function,
                void** user_pointers) {
  return OnCommitted(function, hscene, packet, context, [&](const dacrt::Scene& scene) {
    CheckPointer(valid, "valid");
    bool changed = false;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (valid[lane] == 0) continue;
      RTCPointQuery query{packet->x[lane], packet->y[lane], packet->z[lane], packet->time[lane],
                          packet->radius[lane]};
      changed |= RunPointQuery(scene, query, *context, query_function,
                               user_pointers ? user_pointers[lane] : nullptr);
      packet->radius[lane] = query.radius;
    }
    return changed;
  });
}

}  // namespace

RTC_API bool rtcPointQuery(RTCScene hscene, RTCPointQuery* query, RTCPointQueryContext* context,
                           RTCPointQueryFunction queryFunc, void* userPtr) {
  return OnCommitted(__func__, hscene, query, context, [&](const dacrt::Scene& scene) {
    return RunPointQuery(scene, *query, *context, queryFunc, userPtr);
  });
}

RTC_API bool rtcPointQuery4(const int* valid, RTCScene hscene, RTCPointQuery4* query,
                            RTCPointQueryContext* context, RTCPointQueryFunction queryFunc,
                            void** userPtr) {
  return QueryLanes<4>(__func__, valid, hscene, query, context, queryFunc, userPtr);
}

RTC_API bool rtcPointQuery8(const int* valid, RTCScene hscene, RTCPointQuery8* query,
                            RTCPointQueryContext* context, RTCPointQueryFunction queryFunc,
                            void** userPtr) {
  return QueryLanes<8>(__func__, valid, hscene, query, context, queryFunc, userPtr);
}

RTC_API bool rtcPointQuery16(const int* valid, RTCScene hscene, RTCPointQuery16* query,
                             RTCPointQueryContext* context, RTCPointQueryFunction queryFunc,
                             void** userPtr) {
  return QueryLanes<16>(__func__, valid, hscene, query, context, queryFunc, userPtr);
}

RTC_API void rtcSetGeometryPointQueryFunction(RTCGeometry hgeometry,
                                              RTCPointQueryFunction pointQuery) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetPointQueryFunction(pointQuery); });
}
