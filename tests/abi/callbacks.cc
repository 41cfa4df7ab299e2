#include "callbacks.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace dacrt::tests {
namespace {

/// The widest packets of the libraries.
constexpr unsigned int kMostLanes = 16;

/// A context with what the callbacks need behind it.
struct Call {
  RTCIntersectContext context;
  const std::vector<RTCRayHit>& rays;
  const Judge &geometry, &context_judge;
  Outcome outcome;
};

Call& CallOf(const RTCIntersectContext* context) {
  return *reinterpret_cast<Call*>(const_cast<RTCIntersectContext*>(context));
}

/// The ray that a callback sees in a lane is the caller's, but an instance's geometries see it
/// moved. Returns its number.
int ExpectIsRay(const RTCRay& seen, const Call& call) {
  const int number = NumberOf(seen.org_x);
  const RTCRay& ray = call.rays.at(number).ray;
  EXPECT_EQ(seen.org_y, ray.org_y);
  if (call.context.instID[0] == RTC_INVALID_GEOMETRY_ID) {
    EXPECT_EQ(seen.org_z, ray.org_z);
  }
  EXPECT_EQ(seen.tnear, ray.tnear);
  EXPECT_EQ(seen.dir_x, ray.dir_x);
  EXPECT_EQ(seen.dir_z, ray.dir_z);
  EXPECT_EQ(seen.time, ray.time);
  EXPECT_EQ(seen.mask, ray.mask);
  EXPECT_EQ(seen.id, ray.id);
  EXPECT_EQ(seen.flags, ray.flags);
  return number;
}

bool IsForNothing(const int* valid, unsigned int width) {
  return std::count(valid, valid + width, 0) == width;
}

void Filter(const RTCFilterFunctionNArguments& args, const Judge& judge,
            std::vector<Offer>& offers) {
  Call& call = CallOf(args.context);
  call.outcome.filter_widths.insert(args.N);
  call.outcome.idle_calls += IsForNothing(args.valid, args.N);
  for (unsigned int i = 0; i < args.N; ++i) {
    if (args.valid[i] == 0) continue;
    EXPECT_EQ(args.valid[i], -1);
    const RTCRay ray = rtcGetRayFromRayN(args.ray, args.N, i);
    Offer offer{ExpectIsRay(ray, call), ray.tfar, rtcGetHitFromHitN(args.hit, args.N, i)};
    EXPECT_EQ(offer.hit.instID[0], args.context->instID[0]);
    offers.push_back(offer);
    if (!judge(offer)) {
      args.valid[i] = 0;
      continue;
    }
    rtcCopyHitToHitN(args.hit, &offer.hit, args.N, i);
    RTCRayN_tfar(args.ray, args.N, i) = offer.t;
  }
}

}  // namespace

bool Accept(Offer&) { return true; }
bool Reject(Offer&) { return false; }

void FilterOfGeometry(const RTCFilterFunctionNArguments* args) {
  EXPECT_NE(args->geometryUserPtr, nullptr);
  Call& call = CallOf(args->context);
  Filter(*args, call.geometry, call.outcome.offers);
}

void FilterOfContext(const RTCFilterFunctionNArguments* args) {
  Call& call = CallOf(args->context);
  Filter(*args, call.context_judge, call.outcome.context_offers);
}

Outcome TraceRow(Session& s, RTCScene scene, const Form& form, Query query, const Judge& geometry,
                 const Judge& context, int count) {
  std::vector<RTCRayHit> rays = RowOfRays(form);
  rays.resize(count);
  Call call{{}, rays, geometry, context, {}};
  rtcInitIntersectContext(&call.context);
  if (context) call.context.filter = FilterOfContext;
  call.outcome.rays = Trace(s.api, scene, call.context, form, query, rays);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(call.context.instID[0], RTC_INVALID_GEOMETRY_ID);
  return std::move(call.outcome);
}

namespace {

void BoundSquare(const RTCBoundsFunctionArguments* args) {
  const auto z = static_cast<float>(args->primID);
  *args->bounds_o = {0, 0, z, 0, 1, 1, z, 0};
}

/// The hits of one call of a user function.
struct HitLanes {
  int valid[kMostLanes] = {};
  float values[kMostLanes * sizeof(RTCHit) / sizeof(float)] = {};
  RTCHitN* hits() { return reinterpret_cast<RTCHitN*>(values); }
};

/// Notes the call, and puts the square's hits into `lanes`.
template <class Arguments>
void FindHits(const Arguments& args, RTCRayN* rays, HitLanes& lanes) {
  const auto& squares = *static_cast<const Squares*>(args.geometryUserPtr);
  Call& call = CallOf(args.context);
  call.outcome.user_widths.insert(args.N);
  call.outcome.idle_calls += IsForNothing(args.valid, args.N);
  unsigned int rays_in_call = 0;
  for (unsigned int i = 0; i < args.N; ++i) {
    if (args.valid[i] == 0) continue;
    EXPECT_EQ(args.valid[i], -1);
    ++rays_in_call;
    const RTCRay ray = rtcGetRayFromRayN(rays, args.N, i);
    const unsigned int instance = args.context->instID[0];
    call.outcome.visits.push_back({ExpectIsRay(ray, call), args.geomID, args.primID, instance});
    const float t = static_cast<float>(args.primID) - ray.org_z;
    if (!squares.is_hit || t < ray.tnear || t > ray.tfar || ray.org_x > 1) continue;
    lanes.valid[i] = -1;
    RTCRayN_tfar(rays, args.N, i) = t;
    const RTCHit hit{0, 0, 1, ray.org_x, ray.org_y, args.primID, args.geomID, {instance}};
    rtcCopyHitToHitN(lanes.hits(), &hit, args.N, i);
  }
  call.outcome.rays_a_visit.insert(rays_in_call);
}

/// Finds hits, shows them to `filter`, and calls `accept(lane, hit)` for those that are left.
template <class Arguments, class FilterFunction, class AcceptHit>
void VisitSquare(const Arguments& args, RTCRayN* rays, FilterFunction filter,
                 const AcceptHit& accept) {
  ASSERT_LE(args.N, kMostLanes);
  float tfar[kMostLanes];
  for (unsigned int i = 0; i < args.N; ++i) tfar[i] = RTCRayN_tfar(rays, args.N, i);
  HitLanes lanes;
  FindHits(args, rays, lanes);
  if (static_cast<const Squares*>(args.geometryUserPtr)->asks_filters &&
      std::count(lanes.valid, lanes.valid + args.N, -1) > 0) {
    const RTCFilterFunctionNArguments filter_args{lanes.valid, args.geometryUserPtr, args.context,
                                                  rays,        lanes.hits(),         args.N};
    filter(&args, &filter_args);
  }
  for (unsigned int i = 0; i < args.N; ++i) {
    if (lanes.valid[i]) {
      accept(i, rtcGetHitFromHitN(lanes.hits(), args.N, i));
    } else {
      RTCRayN_tfar(rays, args.N, i) = tfar[i];
    }
  }
}

void IntersectSquare(const RTCIntersectFunctionNArguments* args) {
  const Api& api = static_cast<const Squares*>(args->geometryUserPtr)->api;
  VisitSquare(*args, RTCRayHitN_RayN(args->rayhit, args->N), api.rtcFilterIntersection,
              [&](unsigned int lane, RTCHit hit) {
                rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &hit, args->N, lane);
              });
}

void OccludeSquare(const RTCOccludedFunctionNArguments* args) {
  const Api& api = static_cast<const Squares*>(args->geometryUserPtr)->api;
  VisitSquare(*args, args->ray, api.rtcFilterOcclusion, [&](unsigned int lane, const RTCHit&) {
    RTCRayN_tfar(args->ray, args->N, lane) = -std::numeric_limits<float>::infinity();
  });
}

}  // namespace

RTCGeometry NewSquares(Session& s, Squares& squares) {
  const RTCGeometry geometry = s.Own(s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_USER));
  s.api.rtcSetGeometryUserPrimitiveCount(geometry, squares.count);
  s.api.rtcSetGeometryUserData(geometry, &squares);
  s.api.rtcSetGeometryBoundsFunction(geometry, BoundSquare, nullptr);
  s.api.rtcSetGeometryIntersectFunction(geometry, IntersectSquare);
  s.api.rtcSetGeometryOccludedFunction(geometry, OccludeSquare);
  s.api.rtcSetGeometryIntersectFilterFunction(geometry, FilterOfGeometry);
  s.api.rtcSetGeometryOccludedFilterFunction(geometry, FilterOfGeometry);
  s.api.rtcCommitGeometry(geometry);
  return geometry;
}

unsigned int TopId(const RTCHit& hit) {
  return hit.instID[0] == RTC_INVALID_GEOMETRY_ID ? hit.geomID : hit.instID[0];
}

namespace {

void Sort(std::vector<Offer>& offers) {
  const auto key = [](const Offer& offer) {
    return std::tuple(offer.ray, TopId(offer.hit), offer.hit.primID, offer.t);
  };
  std::sort(offers.begin(), offers.end(),
            [&](const Offer& a, const Offer& b) { return key(a) < key(b); });
}

}  // namespace

void ExpectSameOffers(std::vector<Offer> ours, std::vector<Offer> real) {
  Sort(ours);
  Sort(real);
  ASSERT_EQ(ours.size(), real.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(ours[i].ray, real[i].ray);
    EXPECT_FLOAT_EQ(ours[i].t, real[i].t);
    ExpectSameHit(ours[i].hit, real[i].hit, real[i].t);
  }
}

}  // namespace dacrt::tests
