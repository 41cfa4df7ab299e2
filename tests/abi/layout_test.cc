// The layouts that programs were compiled with. They are checked when this file is compiled; the
// drop-in itself is compiled against the same headers.
#include <embree3/rtcore.h>

#include <cstddef>

namespace {

template <class Type, std::size_t kSize, std::size_t kAlignment>
constexpr bool kHasLayout = sizeof(Type) == kSize && alignof(Type) == kAlignment;

static_assert(kHasLayout<RTCRay, 48, 16>);
static_assert(kHasLayout<RTCHit, 32, 16>);
static_assert(kHasLayout<RTCRayHit, 80, 16>);
static_assert(kHasLayout<RTCRayHit4, 320, 16>);
static_assert(kHasLayout<RTCRayHit8, 640, 32>);
static_assert(kHasLayout<RTCRayHit16, 1280, 64>);
static_assert(kHasLayout<RTCRayNp, 96, 8>);
static_assert(kHasLayout<RTCHitNp, 64, 8>);
static_assert(kHasLayout<RTCRayHitNp, 160, 8>);
static_assert(kHasLayout<RTCIntersectContext, 24, 8>);
static_assert(kHasLayout<RTCFilterFunctionNArguments, 48, 8>);
static_assert(kHasLayout<RTCIntersectFunctionNArguments, 48, 8>);
static_assert(kHasLayout<RTCOccludedFunctionNArguments, 48, 8>);
static_assert(kHasLayout<RTCBounds, 32, 16>);
static_assert(kHasLayout<RTCLinearBounds, 64, 16>);
static_assert(kHasLayout<RTCBuildArguments, 136, 8>);
static_assert(kHasLayout<RTCInterpolateArguments, 88, 8>);
static_assert(kHasLayout<RTCPointQuery, 32, 16>);
static_assert(kHasLayout<RTCPointQueryContext, 144, 16>);

static_assert(offsetof(RTCRay, tnear) == 12);
static_assert(offsetof(RTCRay, dir_x) == 16);
static_assert(offsetof(RTCRay, time) == 28);
static_assert(offsetof(RTCRay, tfar) == 32);
static_assert(offsetof(RTCRay, mask) == 36);
static_assert(offsetof(RTCRay, id) == 40);
static_assert(offsetof(RTCRay, flags) == 44);
static_assert(offsetof(RTCRayHit, hit) == 48);
static_assert(offsetof(RTCHit, u) == 12);
static_assert(offsetof(RTCHit, primID) == 20);
static_assert(offsetof(RTCHit, geomID) == 24);
static_assert(offsetof(RTCHit, instID) == 28);
static_assert(offsetof(RTCRayHit16, hit) == 768);
static_assert(offsetof(RTCRayHitNp, hit) == 96);
static_assert(offsetof(RTCIntersectContext, filter) == 8);
static_assert(offsetof(RTCIntersectContext, instID) == 16);
static_assert(offsetof(RTCBounds, upper_x) == 16);

static_assert(sizeof(RTCError) == 4 && sizeof(RTCFormat) == 4 && sizeof(RTCSceneFlags) == 4);
static_assert(RTC_MAX_INSTANCE_LEVEL_COUNT == 1 && RTC_MIN_WIDTH == 0);
static_assert(RTC_VERSION == 31305);

}  // namespace
