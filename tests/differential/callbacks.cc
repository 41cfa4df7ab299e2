#include "callbacks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace dacrt::tests {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The widest packets of the libraries.
constexpr uint32_t kMostLanes = 16;

CallContext& ContextOf(const RTCIntersectContext* context) {
  return *reinterpret_cast<CallContext*>(const_cast<RTCIntersectContext*>(context));
}

void Filter(const RTCFilterFunctionNArguments& arguments, FilterKind kind, bool by_context) {
  CallContext& call = ContextOf(arguments.context);
  if (!call.in_user_function) call.fewest_lanes = std::min(call.fewest_lanes, arguments.N);
  for (uint32_t i = 0; i < arguments.N; ++i) {
    if (arguments.valid[i] == 0) continue;
    if (arguments.valid[i] != -1) call.fault = "valid is neither 0 nor -1";
    const RTCHit hit = rtcGetHitFromHitN(arguments.hit, arguments.N, i);
    const uint32_t ray_id = RTCRayN_id(arguments.ray, arguments.N, i);
    if (hit.instID[0] != arguments.context->instID[0]) {
      call.fault = "the hit's instID is not the context's";
    }
    call.offers.push_back({ray_id, hit, RTCRayN_tfar(arguments.ray, arguments.N, i), by_context});
    if (Rejects(kind, ray_id, hit)) arguments.valid[i] = 0;
    if (kind == FilterKind::kChange) {
      RTCHitN_u(arguments.hit, arguments.N, i) = kChangedU;
      RTCHitN_v(arguments.hit, arguments.N, i) = kChangedV;
    }
  }
}

void FilterForContext(const RTCFilterFunctionNArguments* arguments) {
  Filter(*arguments, ContextOf(arguments->context).context_filter, true);
}

const WorldGeometry& GeometryOf(void* user_pointer) {
  return *static_cast<const GeometryData*>(user_pointer)->geometry;
}

struct Sphere {
  Double3 center;
  double radius;
};

Sphere SphereAt(const WorldGeometry& geometry, uint32_t primitive, double time) {
  const auto& steps = geometry.vertices;
  std::size_t step = 0;
  double fraction = 0;
  if (steps.size() > 1) {
    const auto segments = static_cast<double>(steps.size() - 1);
    const double place = (time - geometry.time_begin) /
                         (static_cast<double>(geometry.time_end) - geometry.time_begin) * segments;
    const double floor = std::clamp(std::floor(place), 0.0, segments - 1);
    step = static_cast<std::size_t>(floor);
    fraction = place - floor;
  }
  const Vertex& a = steps[step][primitive];
  const Vertex& b = steps[fraction == 0 ? step : step + 1][primitive];
  const auto between = [&](double x, double y) { return x + fraction * (y - x); };
  return {{between(a.x, b.x), between(a.y, b.y), between(a.z, b.z)}, between(a.radius, b.radius)};
}

/// Where a ray crosses a sphere, near side first; no crossings if it misses it.
struct Crossings {
  float t[2];
  Float3 normal[2];
  int count = 0;
};

/// `wins_ties` says whether one at tfar counts.
Crossings Cross(const Sphere& sphere, RTCRayN* rays, uint32_t width, uint32_t lane,
                bool wins_ties) {
  const Double3 origin{RTCRayN_org_x(rays, width, lane), RTCRayN_org_y(rays, width, lane),
                       RTCRayN_org_z(rays, width, lane)};
  const Double3 direction{RTCRayN_dir_x(rays, width, lane), RTCRayN_dir_y(rays, width, lane),
                          RTCRayN_dir_z(rays, width, lane)};
  const double length2 = Dot(direction, direction);
  const Double3 to_center = sphere.center - origin;
  const double middle = Dot(to_center, direction) / length2;
  const Double3 beside = to_center - middle * direction;
  const double rest = sphere.radius * sphere.radius - Dot(beside, beside);
  Crossings crossings;
  if (!(rest >= 0) || !(length2 > 0)) return crossings;
  const double half = std::sqrt(rest / length2);
  for (const double along : {-half, half}) {
    const auto t = static_cast<float>(middle + along);
    crossings.t[crossings.count] = t;
    crossings.normal[crossings.count] = Float3(along * direction - beside);
    const float tfar = RTCRayN_tfar(rays, width, lane);
    if (RTCRayN_tnear(rays, width, lane) <= t && (t < tfar || (t == tfar && wins_ties))) {
      ++crossings.count;
    }
  }
  return crossings;
}

/// Traces the ray of a lane, as a user function may that has to know more. What is found does not
/// matter; the call that is under way must not notice.
void TraceAgain(const GeometryData& data, RTCRayN* rays, uint32_t width, uint32_t lane) {
  if (!data.traced_again) return;
  CallContext inner = MakeContext(FilterKind::kNone);
  RTCRayHit record{};
  record.ray = rtcGetRayFromRayN(rays, width, lane);
  record.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCRay shadow = record.ray;
  data.api->rtcIntersect1(data.traced_again, &inner.context, &record);
  data.api->rtcOccluded1(data.traced_again, &inner.context, &shadow);
}

/// Marks the call as one by the program for as long as it lives.
class InUserFunction {
 public:
  explicit InUserFunction(CallContext& call) : call_(call) { call_.in_user_function = true; }
  ~InUserFunction() { call_.in_user_function = false; }

 private:
  CallContext& call_;
};

struct HitPacket {
  float values[8 * kMostLanes];
  RTCHitN* get() { return reinterpret_cast<RTCHitN*>(values); }
};

/// Whether a primitive comes before the hit that a ray has, as hits of meshes do: which of two
/// spheres at the same distance is hit would else depend on which was asked first. There are no
/// hits so far in any-hit queries.
template <typename Arguments>
bool ComesFirst(const Arguments& arguments, RTCHitN* hits, uint32_t lane) {
  if (hits == nullptr) return true;
  const RTCHit hit = rtcGetHitFromHitN(hits, arguments.N, lane);
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return true;
  const auto name = [](uint32_t instance, uint32_t geometry, uint32_t primitive) {
    return std::tuple(instance == RTC_INVALID_GEOMETRY_ID ? geometry : instance, geometry,
                      primitive);
  };
  return name(arguments.context->instID[0], arguments.geomID, arguments.primID) <
         name(hit.instID[0], hit.geomID, hit.primID);
}

/// Shows the `turn`-th crossing of every ray that has one to `filter`, which is given the candidate
/// hits, and calls `accept(lane, t, hit)` for those that it leaves valid.
template <typename Arguments, typename FilterFunction, typename Accept>
void OfferCrossings(const Arguments& arguments, RTCRayN* rays, RTCHitN* so_far,
                    FilterFunction filter, const Accept& accept) {
  const auto& data = *static_cast<const GeometryData*>(arguments.geometryUserPtr);
  const uint32_t width = arguments.N;
  CallContext& call = ContextOf(arguments.context);
  if (width > kMostLanes) {
    call.fault = "a user function is called with more than 16 rays";
    return;
  }
  Crossings crossings[kMostLanes];
  bool is_open[kMostLanes] = {};
  for (uint32_t i = 0; i < width; ++i) {
    if (arguments.valid[i] == 0) continue;
    if (arguments.valid[i] != -1) call.fault = "valid is neither 0 nor -1";
    crossings[i] = Cross(SphereAt(*data.geometry, arguments.primID, RTCRayN_time(rays, width, i)),
                         rays, width, i, ComesFirst(arguments, so_far, i));
    is_open[i] = true;
    TraceAgain(data, rays, width, i);
  }
  for (int turn = 0; turn < 2; ++turn) {
    int valid[kMostLanes] = {};
    float tfar[kMostLanes];
    HitPacket hits{};
    bool any = false;
    for (uint32_t i = 0; i < width; ++i) {
      if (!is_open[i] || turn >= crossings[i].count) continue;
      any = true;
      valid[i] = -1;
      tfar[i] = RTCRayN_tfar(rays, width, i);
      RTCRayN_tfar(rays, width, i) = crossings[i].t[turn];
      const Float3& normal = crossings[i].normal[turn];
      RTCHit hit{normal.x, normal.y,         normal.z,         0,
                 0,        arguments.primID, arguments.geomID, {arguments.context->instID[0]}};
      rtcCopyHitToHitN(hits.get(), &hit, width, i);
    }
    if (!any) return;
    bool was_valid[kMostLanes];
    std::copy_n(valid, kMostLanes, was_valid);
    const RTCFilterFunctionNArguments filter_arguments{
        valid, arguments.geometryUserPtr, arguments.context, rays, hits.get(), width};
    {
      const InUserFunction mark(call);
      filter (*data.api)(&arguments, &filter_arguments);
    }
    for (uint32_t i = 0; i < width; ++i) {
      if (valid[i]) {
        accept(i, hits.get());
        is_open[i] = false;
      } else if (was_valid[i]) {
        RTCRayN_tfar(rays, width, i) = tfar[i];
      }
    }
  }
}

}  // namespace

CallContext MakeContext(FilterKind context_filter) {
  CallContext call;
  rtcInitIntersectContext(&call.context);
  call.context_filter = context_filter;
  if (context_filter != FilterKind::kNone) call.context.filter = FilterForContext;
  return call;
}

void FilterClosest(const RTCFilterFunctionNArguments* arguments) {
  Filter(*arguments, GeometryOf(arguments->geometryUserPtr).closest_filter, false);
}

void FilterAny(const RTCFilterFunctionNArguments* arguments) {
  Filter(*arguments, GeometryOf(arguments->geometryUserPtr).any_filter, false);
}

void BoundUserPrimitive(const RTCBoundsFunctionArguments* arguments) {
  const WorldGeometry& geometry = GeometryOf(arguments->geometryUserPtr);
  const Vertex& v = geometry.vertices[arguments->timeStep][arguments->primID];
  // One float further, because the sums are rounded.
  const auto lower = [&](float center) { return std::nextafter(center - v.radius, -kInfinity); };
  const auto upper = [&](float center) { return std::nextafter(center + v.radius, kInfinity); };
  *arguments->bounds_o = {lower(v.x), lower(v.y), lower(v.z), 0,
                          upper(v.x), upper(v.y), upper(v.z), 0};
}

void IntersectUserPrimitive(const RTCIntersectFunctionNArguments* arguments) {
  RTCRayN* const rays = RTCRayHitN_RayN(arguments->rayhit, arguments->N);
  RTCHitN* const hits = RTCRayHitN_HitN(arguments->rayhit, arguments->N);
  OfferCrossings(
      *arguments, rays, hits, [](const EmbreeApi& api) { return api.rtcFilterIntersection; },
      [&](uint32_t lane, RTCHitN* accepted) {
        const RTCHit hit = rtcGetHitFromHitN(accepted, arguments->N, lane);
        rtcCopyHitToHitN(hits, &hit, arguments->N, lane);
      });
}

void OccludeUserPrimitive(const RTCOccludedFunctionNArguments* arguments) {
  OfferCrossings(
      *arguments, arguments->ray, nullptr,
      [](const EmbreeApi& api) { return api.rtcFilterOcclusion; },
      [&](uint32_t lane, RTCHitN*) {
        RTCRayN_tfar(arguments->ray, arguments->N, lane) = -kInfinity;
      });
}

}  // namespace dacrt::tests
