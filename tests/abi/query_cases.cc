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

const QueryFunction kQueryFunctions[] = {
    {"rtcIntersect1",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcIntersect1(scene, context, static_cast<RTCRayHit*>(rays));
     }},
    {"rtcIntersect4",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcIntersect4(valid, scene, context, static_cast<RTCRayHit4*>(rays));
     },
     true},
    {"rtcIntersect8",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcIntersect8(valid, scene, context, static_cast<RTCRayHit8*>(rays));
     },
     true},
    {"rtcIntersect16",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcIntersect16(valid, scene, context, static_cast<RTCRayHit16*>(rays));
     },
     true},
    {"rtcIntersect1M",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcIntersect1M(scene, context, static_cast<RTCRayHit*>(rays), 1, sizeof(RTCRayHit));
     }},
    {"rtcIntersect1Mp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       auto* pointer = static_cast<RTCRayHit*>(rays);
       api.rtcIntersect1Mp(scene, context, rays ? &pointer : nullptr, 1);
     }},
    {"rtcIntersectNM",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcIntersectNM(scene, context, static_cast<RTCRayHitN*>(rays), 1, 1, sizeof(RTCRayHit));
     }},
    {"rtcIntersectNp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       const auto pointers = PointersTo<RTCRayHitNp>(rays);
       api.rtcIntersectNp(scene, context, rays ? &pointers : nullptr, 1);
     }},
    {"rtcOccluded1",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcOccluded1(scene, context, static_cast<RTCRay*>(rays));
     }},
    {"rtcOccluded4",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcOccluded4(valid, scene, context, static_cast<RTCRay4*>(rays));
     },
     true},
    {"rtcOccluded8",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcOccluded8(valid, scene, context, static_cast<RTCRay8*>(rays));
     },
     true},
    {"rtcOccluded16",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcOccluded16(valid, scene, context, static_cast<RTCRay16*>(rays));
     },
     true},
    {"rtcOccluded1M",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcOccluded1M(scene, context, static_cast<RTCRay*>(rays), 1, sizeof(RTCRay));
     }},
    {"rtcOccluded1Mp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       auto* pointer = static_cast<RTCRay*>(rays);
       api.rtcOccluded1Mp(scene, context, rays ? &pointer : nullptr, 1);
     }},
    {"rtcOccludedNM",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcOccludedNM(scene, context, static_cast<RTCRayN*>(rays), 1, 1, sizeof(RTCRay));
     }},
    {"rtcOccludedNp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       const auto pointers = PointersTo<RTCRayNp>(rays);
       api.rtcOccludedNp(scene, context, rays ? &pointers : nullptr, 1);
     }},
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
