// rtcore_scene.h, the queries. As in Embree they trust the scene's handle: they are called too
// often for a look-up. All go the same way, through a view of the rays, to dacrt::Scene::Trace.
#include <embree3/rtcore.h>

#include <optional>

#include "boundary.h"
#include "device.h"
#include "ray_streams.h"
#include "scene.h"

using namespace dacrt::compat;
using dacrt::Query;
using dacrt::RayView;

namespace {

constexpr uint32_t kStream = 0;

/// Lanes that callbacks see from a stream call, as with Embree; never 1, also for a single record,
/// which Embree answers as rtcIntersect1 does.
uint32_t StreamWidth(const Device& device, const RTCIntersectContext& context) {
  const dacrt::InstructionSet instruction_set = device.engine()->instruction_set();
  if (instruction_set < dacrt::InstructionSet::kAvx2) return 4;
  const bool is_coherent = (context.flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT) != 0;
  return is_coherent && instruction_set == dacrt::InstructionSet::kAvx512 ? 16 : 8;
}

/// Answers `query` for the `count` rays at `rays`, the argument called `name`, which `make_view`
/// describes. Callbacks see `width` lanes; kStream means a stream's.
template <class MakeView>
void Trace(const char* function, RTCScene hscene, RTCIntersectContext* context, const void* rays,
           const char* name, std::size_t count, uint32_t width, Query query, MakeView make_view) {
  Scene* const scene = ToObject(hscene);
  Guarded(function, scene ? scene->device().get() : nullptr, [&] {
    CheckPointer(scene, "scene");
    const dacrt::Scene& committed = scene->Committed();
    // In a divided scene a rank without rays works on those of others.
    dacrt::mpi::GroupScene* const shared = width == kStream ? scene->CommittedTogether() : nullptr;
    if (count == 0 && !shared) return;
    CheckPointer(context, "context");
    if (count > 0) CheckPointer(rays, name);
    RayView view = count > 0 ? make_view() : RayView();
    view.instance_value = context->instID[0];
    if (scene->device()->ignore_masks()) view.mask = RayView::kAbsent;
    const dacrt::CallOptions options{
        width != kStream ? width : StreamWidth(*scene->device(), *context), context};
    if (shared) {
      shared->Trace(query, view, options);
    } else {
      committed.Trace(query, view, options);
    }
  });
}

/// Answers `query` for the valid lanes of the packet at `packet`, the argument called `name`.
void TraceLanes(const char* function, const int* valid, RTCScene hscene,
                RTCIntersectContext* context, void* packet, const char* name, std::size_t lanes,
                Query query, Record record) {
  std::optional<LaneView> view;  // The engine reads through it.
  Trace(function, hscene, context, packet, name, lanes, static_cast<uint32_t>(lanes), query, [&] {
    CheckPointer(valid, "valid");
    return view.emplace(packet, lanes, valid, record).view();
  });
}

}  // namespace

RTC_API void rtcIntersect1(RTCScene hscene, RTCIntersectContext* context, RTCRayHit* rayhit) {
  Trace(__func__, hscene, context, rayhit, "rayhit", 1, 1, Query::kClosest,
        [&] { return PacketView(rayhit, 1, 1, 0, Record::kRayHit); });
}

RTC_API void rtcIntersect4(const int* valid, RTCScene hscene, RTCIntersectContext* context,
                           RTCRayHit4* rayhit) {
  TraceLanes(__func__, valid, hscene, context, rayhit, "rayhit", 4, Query::kClosest,
             Record::kRayHit);
}

RTC_API void rtcIntersect8(const int* valid, RTCScene hscene, RTCIntersectContext* context,
                           RTCRayHit8* rayhit) {
  TraceLanes(__func__, valid, hscene, context, rayhit, "rayhit", 8, Query::kClosest,
             Record::kRayHit);
}

RTC_API void rtcIntersect16(const int* valid, RTCScene hscene, RTCIntersectContext* context,
                            RTCRayHit16* rayhit) {
  TraceLanes(__func__, valid, hscene, context, rayhit, "rayhit", 16, Query::kClosest,
             Record::kRayHit);
}

RTC_API void rtcIntersect1M(RTCScene hscene, RTCIntersectContext* context, RTCRayHit* rayhit,
                            unsigned int M, size_t byteStride) {
  Trace(__func__, hscene, context, rayhit, "rayhit", M, kStream, Query::kClosest,
        [&] { return PacketView(rayhit, 1, M, byteStride, Record::kRayHit); });
}

RTC_API void rtcIntersect1Mp(RTCScene hscene, RTCIntersectContext* context, RTCRayHit** rayhit,
                             unsigned int M) {
  Trace(__func__, hscene, context, rayhit, "rayhit", M, kStream, Query::kClosest,
        [&] { return PointerView(reinterpret_cast<void**>(rayhit), M, Record::kRayHit); });
}

RTC_API void rtcIntersectNM(RTCScene hscene, RTCIntersectContext* context, RTCRayHitN* rayhit,
                            unsigned int N, unsigned int M, size_t byteStride) {
  Trace(__func__, hscene, context, rayhit, "rayhit", std::size_t{N} * M, kStream, Query::kClosest,
        [&] { return PacketView(rayhit, N, M, byteStride, Record::kRayHit); });
}

RTC_API void rtcIntersectNp(RTCScene hscene, RTCIntersectContext* context,
                            const RTCRayHitNp* rayhit, unsigned int N) {
  Trace(__func__, hscene, context, rayhit, "rayhit", N, kStream, Query::kClosest,
        [&] { return ComponentView(*rayhit, N); });
}

RTC_API void rtcOccluded1(RTCScene hscene, RTCIntersectContext* context, RTCRay* ray) {
  Trace(__func__, hscene, context, ray, "ray", 1, 1, Query::kAny,
        [&] { return PacketView(ray, 1, 1, 0, Record::kRay); });
}

RTC_API void rtcOccluded4(const int* valid, RTCScene hscene, RTCIntersectContext* context,
                          RTCRay4* ray) {
  TraceLanes(__func__, valid, hscene, context, ray, "ray", 4, Query::kAny, Record::kRay);
}

RTC_API void rtcOccluded8(const int* valid, RTCScene hscene, RTCIntersectContext* context,
                          RTCRay8* ray) {
  TraceLanes(__func__, valid, hscene, context, ray, "ray", 8, Query::kAny, Record::kRay);
}

RTC_API void rtcOccluded16(const int* valid, RTCScene hscene, RTCIntersectContext* context,
                           RTCRay16* ray) {
  TraceLanes(__func__, valid, hscene, context, ray, "ray", 16, Query::kAny, Record::kRay);
}

RTC_API void rtcOccluded1M(RTCScene hscene, RTCIntersectContext* context, RTCRay* ray,
                           unsigned int M, size_t byteStride) {
  Trace(__func__, hscene, context, ray, "ray", M, kStream, Query::kAny,
        [&] { return PacketView(ray, 1, M, byteStride, Record::kRay); });
}

RTC_API void rtcOccluded1Mp(RTCScene hscene, RTCIntersectContext* context, RTCRay** ray,
                            unsigned int M) {
  Trace(__func__, hscene, context, ray, "ray", M, kStream, Query::kAny,
        [&] { return PointerView(reinterpret_cast<void**>(ray), M, Record::kRay); });
}

RTC_API void rtcOccludedNM(RTCScene hscene, RTCIntersectContext* context, RTCRayN* ray,
                           unsigned int N, unsigned int M, size_t byteStride) {
  Trace(__func__, hscene, context, ray, "ray", std::size_t{N} * M, kStream, Query::kAny,
        [&] { return PacketView(ray, N, M, byteStride, Record::kRay); });
}

RTC_API void rtcOccludedNp(RTCScene hscene, RTCIntersectContext* context, const RTCRayNp* ray,
                           unsigned int N) {
  Trace(__func__, hscene, context, ray, "ray", N, kStream, Query::kAny,
        [&] { return ComponentView(*ray, N); });
}
