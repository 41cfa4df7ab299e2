#include <array>
#include <bit>

#include "error_cases.h"

namespace dacrt::tests {
namespace {

/// Pointers of which all go to `values`.
template <class Pointers>
Pointers PointersTo(void* values) {
  std::array<void*, sizeof(Pointers) / sizeof(void*)> all;
  all.fill(values);
  return std::bit_cast<Pointers>(all);
}

/// Calls a query function with these arguments, for one ray or packet at `rays`.
struct QueryFunction {
  const char* name;
  void (*call)(const Api&, const int* valid, RTCScene, RTCIntersectContext*, void* rays);
  bool is_packet = false;
};

// One body for each form, over the functions of both queries and their structures.

template <auto kFunction, class Rays>
void CallSingle(const Api& api, const int*, RTCScene scene, RTCIntersectContext* context,
                void* rays) {
  (api.*kFunction)(scene, context, static_cast<Rays*>(rays));
}

template <auto kFunction, class Rays>
void CallPacket(const Api& api, const int* valid, RTCScene scene, RTCIntersectContext* context,
                void* rays) {
  (api.*kFunction)(valid, scene, context, static_cast<Rays*>(rays));
}

template <auto kFunction, class Rays>
void CallRecords(const Api& api, const int*, RTCScene scene, RTCIntersectContext* context,
                 void* rays) {
  (api.*kFunction)(scene, context, static_cast<Rays*>(rays), 1, sizeof(Rays));
}

template <auto kFunction, class Rays>
void CallPointers(const Api& api, const int*, RTCScene scene, RTCIntersectContext* context,
                  void* rays) {
  auto* pointer = static_cast<Rays*>(rays);
  (api.*kFunction)(scene, context, rays ? &pointer : nullptr, 1);
}

template <auto kFunction, class Rays, class Record>
void CallPackets(const Api& api, const int*, RTCScene scene, RTCIntersectContext* context,
                 void* rays) {
  (api.*kFunction)(scene, context, static_cast<Rays*>(rays), 1, 1, sizeof(Record));
}

template <auto kFunction, class Pointers>
void CallArrays(const Api& api, const int*, RTCScene scene, RTCIntersectContext* context,
                void* rays) {
  const auto pointers = PointersTo<Pointers>(rays);
  (api.*kFunction)(scene, context, rays ? &pointers : nullptr, 1);
}

const QueryFunction kQueryFunctions[] = {
    {"rtcIntersect1", CallSingle<&Api::rtcIntersect1, RTCRayHit>},
    {"rtcIntersect4", CallPacket<&Api::rtcIntersect4, RTCRayHit4>, true},
    {"rtcIntersect8", CallPacket<&Api::rtcIntersect8, RTCRayHit8>, true},
    {"rtcIntersect16", CallPacket<&Api::rtcIntersect16, RTCRayHit16>, true},
    {"rtcIntersect1M", CallRecords<&Api::rtcIntersect1M, RTCRayHit>},
    {"rtcIntersect1Mp", CallPointers<&Api::rtcIntersect1Mp, RTCRayHit>},
    {"rtcIntersectNM", CallPackets<&Api::rtcIntersectNM, RTCRayHitN, RTCRayHit>},
    {"rtcIntersectNp", CallArrays<&Api::rtcIntersectNp, RTCRayHitNp>},
    {"rtcOccluded1", CallSingle<&Api::rtcOccluded1, RTCRay>},
    {"rtcOccluded4", CallPacket<&Api::rtcOccluded4, RTCRay4>, true},
    {"rtcOccluded8", CallPacket<&Api::rtcOccluded8, RTCRay8>, true},
    {"rtcOccluded16", CallPacket<&Api::rtcOccluded16, RTCRay16>, true},
    {"rtcOccluded1M", CallRecords<&Api::rtcOccluded1M, RTCRay>},
    {"rtcOccluded1Mp", CallPointers<&Api::rtcOccluded1Mp, RTCRay>},
    {"rtcOccludedNM", CallPackets<&Api::rtcOccludedNM, RTCRayN, RTCRay>},
    {"rtcOccludedNp", CallArrays<&Api::rtcOccludedNp, RTCRayNp>},
};

}  // namespace

std::vector<Case> Queries() {
  static RTCIntersectContext context;
  static RTCRayHit16 packet;
  alignas(64) static const int valid[16] = {-1};
  rtcInitIntersectContext(&context);
  std::vector<Case> cases;
  for (const QueryFunction& function : kQueryFunctions) {
    const char* const name = function.name;
    const auto call = function.call;
    cases.push_back(OnDevice(name, "a scene that was not committed", kOperation, [=](auto& s) {
      call(s.api, valid, s.NewScene(), &context, &packet);
    }));
    cases.push_back(OnlyOurs(name, "a null scene",
                             [=](auto& s) { call(s.api, valid, nullptr, &context, &packet); }));
    cases.push_back(OnDevice(
        name, "a null context", kArgument,
        [=](auto& s) { call(s.api, valid, s.SceneOf(s.Triangle()), nullptr, &packet); },
        Real::kCrashes));
    cases.push_back(OnDevice(
        name, "null rays", kArgument,
        [=](auto& s) { call(s.api, valid, s.SceneOf(s.Triangle()), &context, nullptr); },
        Real::kCrashes));
    if (!function.is_packet) continue;
    cases.push_back(OnDevice(
        name, "null valid flags", kArgument,
        [=](auto& s) { call(s.api, nullptr, s.SceneOf(s.Triangle()), &context, &packet); },
        Real::kCrashes));
  }
  cases.push_back(OnDevice(
      "rtcIntersectNp", "null origins", kArgument,
      [](auto& s) {
        const RTCRayHitNp pointers{};
        s.api.rtcIntersectNp(s.SceneOf(s.Triangle()), &context, &pointers, 1);
      },
      Real::kCrashes));
  cases.push_back(OnDevice(
      "rtcOccludedNp", "null origins", kArgument,
      [](auto& s) {
        const RTCRayNp pointers{};
        s.api.rtcOccludedNp(s.SceneOf(s.Triangle()), &context, &pointers, 1);
      },
      Real::kCrashes));
  cases.push_back(OnDevice("rtcIntersect1M", "no rays at a null pointer", kNone, [](auto& s) {
    s.api.rtcIntersect1M(s.SceneOf(s.Triangle()), &context, nullptr, 0, sizeof(RTCRayHit));
  }));
  return cases;
}

}  // namespace dacrt::tests
