#include "callbacks.h"

#include <algorithm>
#include <cstddef>

#include "geometry.h"

namespace dacrt::compat {
namespace {

// The engine's packets are Embree's.
template <class Packet, std::size_t kLanes>
constexpr bool HasLayoutOfEngine() {
  const auto place = [](PacketComponent component) {
    return static_cast<std::size_t>(component) * kLanes * sizeof(float);
  };
  using enum PacketComponent;
  return offsetof(Packet, ray.org_x) == place(kOrgX) &&
         offsetof(Packet, ray.tnear) == place(kTnear) &&
         offsetof(Packet, ray.dir_x) == place(kDirX) &&
         offsetof(Packet, ray.time) == place(kTime) && offsetof(Packet, ray.tfar) == place(kTfar) &&
         offsetof(Packet, ray.mask) == place(kMask) && offsetof(Packet, ray.id) == place(kId) &&
         offsetof(Packet, ray.flags) == place(kFlags) &&
         offsetof(Packet, hit.Ng_x) == place(kNgX) && offsetof(Packet, hit.u) == place(kU) &&
         offsetof(Packet, hit.v) == place(kV) &&
         offsetof(Packet, hit.primID) == place(kPrimitiveId) &&
         offsetof(Packet, hit.geomID) == place(kGeometryId) &&
         offsetof(Packet, hit.instID) == place(kInstanceId);
}
static_assert(HasLayoutOfEngine<RTCRayHit, 1>());
static_assert(HasLayoutOfEngine<RTCRayHit4, 4>());
static_assert(HasLayoutOfEngine<RTCRayHit8, 8>());
static_assert(HasLayoutOfEngine<RTCRayHit16, 16>());

RTCIntersectContext* ContextOf(const CallbackArguments& arguments) {
  return static_cast<RTCIntersectContext*>(arguments.call);
}

/// The context names the instance while a function is called for a ray that is in one.
class InstanceInContext {
 public:
  explicit InstanceInContext(const CallbackArguments& arguments)
      : context_(*ContextOf(arguments)), before_(context_.instID[0]) {
    context_.instID[0] = arguments.instance_id;
  }
  ~InstanceInContext() { context_.instID[0] = before_; }
  InstanceInContext(const InstanceInContext&) = delete;
  InstanceInContext& operator=(const InstanceInContext&) = delete;

 private:
  RTCIntersectContext& context_;
  const unsigned int before_;
};

/// What user functions are called with, and behind it what rtcFilterIntersection needs.
template <class Arguments>
struct UserArguments : Arguments {
  const Geometry* geometry;
};

template <bool kContextFilter>
void Filter(void* data, const CallbackArguments& arguments) {
  const auto& geometry = *static_cast<const Geometry*>(data);
  const InstanceInContext instance(arguments);
  RTCFilterFunctionNArguments args;
  args.valid = arguments.valid;
  args.geometryUserPtr = geometry.user_data();
  args.context = ContextOf(arguments);
  args.ray = static_cast<RTCRayN*>(arguments.packet);
  args.hit = RTCRayHitN_HitN(static_cast<RTCRayHitN*>(arguments.packet), arguments.width);
  args.N = arguments.width;
  const GeometryCallbacks& callbacks = geometry.callbacks();
  const RTCFilterFunctionN own =
      arguments.query == Query::kClosest ? callbacks.closest_filter : callbacks.any_filter;
  if (own) own(&args);
  if (!kContextFilter || !args.context->filter) return;
  const auto is_live = [](int lane) { return lane != 0; };
  if (std::any_of(args.valid, args.valid + args.N, is_live)) args.context->filter(&args);
}

template <class Arguments>
UserArguments<Arguments> MakeUserArguments(const Geometry& geometry,
                                           const CallbackArguments& arguments) {
  UserArguments<Arguments> args;
  args.valid = arguments.valid;
  args.geometryUserPtr = geometry.user_data();
  args.primID = arguments.primitive_id;
  args.context = ContextOf(arguments);
  args.N = arguments.width;
  args.geomID = arguments.geometry_id;
  args.geometry = &geometry;
  return args;
}

void Intersect(void* data, const CallbackArguments& arguments) {
  const auto& geometry = *static_cast<const Geometry*>(data);
  const RTCIntersectFunctionN function = geometry.callbacks().intersect;
  if (!function) return;
  const InstanceInContext instance(arguments);
  auto args = MakeUserArguments<RTCIntersectFunctionNArguments>(geometry, arguments);
  args.rayhit = static_cast<RTCRayHitN*>(arguments.packet);
  function(&args);
}

void Occluded(void* data, const CallbackArguments& arguments) {
  const auto& geometry = *static_cast<const Geometry*>(data);
  const RTCOccludedFunctionN function = geometry.callbacks().occluded;
  if (!function) return;
  const InstanceInContext instance(arguments);
  auto args = MakeUserArguments<RTCOccludedFunctionNArguments>(geometry, arguments);
  args.ray = static_cast<RTCRayN*>(arguments.packet);
  function(&args);
}

/// As in Embree, the context's function is asked without RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
/// too, and also where nothing is left.
void RunFilters(RTCFilterFunctionN own, const RTCFilterFunctionNArguments& args) {
  if (own) own(&args);
  if (args.context->filter) args.context->filter(&args);
}

void BoundPrimitive(void* data, uint32_t primitive, uint32_t time_step, Bounds& bounds) {
  const auto& geometry = *static_cast<const Geometry*>(data);
  RTCBounds embree_bounds;
  embree_bounds.lower_x = embree_bounds.lower_y = embree_bounds.lower_z = 1;
  embree_bounds.upper_x = embree_bounds.upper_y = embree_bounds.upper_z = -1;
  RTCBoundsFunctionArguments args;
  args.geometryUserPtr = geometry.user_data();
  args.primID = primitive;
  args.timeStep = time_step;
  args.bounds_o = &embree_bounds;
  geometry.callbacks().bounds(&args);
  bounds = {{embree_bounds.lower_x, embree_bounds.lower_y, embree_bounds.lower_z},
            {embree_bounds.upper_x, embree_bounds.upper_y, embree_bounds.upper_z}};
}

}  // namespace

void SetCallbacks(Geometry& geometry, bool context_filter, dacrt::Geometry& description) {
  const GeometryCallbacks& callbacks = geometry.callbacks();
  if (geometry.type() == RTC_GEOMETRY_TYPE_USER) {
    if (callbacks.bounds) description.bounds = {BoundPrimitive, &geometry};
    description.intersect = {Intersect, &geometry};
    description.occluded = {Occluded, &geometry};
    return;
  }
  if (geometry.type() == RTC_GEOMETRY_TYPE_INSTANCE) return;
  const Callback filter{context_filter ? Filter<true> : Filter<false>, &geometry};
  if (callbacks.closest_filter || context_filter) description.closest_filter = filter;
  if (callbacks.any_filter || context_filter) description.any_filter = filter;
}

void FilterFromUserFunction(const RTCIntersectFunctionNArguments& args,
                            const RTCFilterFunctionNArguments& filter_args) {
  const auto& own = static_cast<const UserArguments<RTCIntersectFunctionNArguments>&>(args);
  RunFilters(own.geometry->callbacks().closest_filter, filter_args);
}

void FilterFromUserFunction(const RTCOccludedFunctionNArguments& args,
                            const RTCFilterFunctionNArguments& filter_args) {
  const auto& own = static_cast<const UserArguments<RTCOccludedFunctionNArguments>&>(args);
  RunFilters(own.geometry->callbacks().any_filter, filter_args);
}

}  // namespace dacrt::compat
