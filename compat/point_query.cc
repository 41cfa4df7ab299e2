#include "point_query.h"

#include "boundary.h"
#include "geometry.h"
#include "transform_format.h"

namespace dacrt::compat {
namespace {

constexpr RTCFormat kMatrix = RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR;

/// What the program's functions are called with.
struct Call {
  RTCPointQuery& query;
  RTCPointQueryContext& context;
  RTCPointQueryFunction function;
  void* user_pointer;
  float similarity_scale;  ///< outside of the scene's instances
  bool changed = false;
};

/// An instance on the context's stack. As in Embree, its matrices stay there afterwards.
class InstanceOnStack {
 public:
  InstanceOnStack(RTCPointQueryContext& context, const InstanceSpace* instance)
      : context_(instance ? &context : nullptr) {
    if (!instance) return;
    WriteTransform(instance->to_instance, kMatrix, context.world2inst[0]);
    WriteTransform(instance->from_instance, kMatrix, context.inst2world[0]);
    context.instID[0] = instance->instance_id;
    context.instStackSize = 1;
  }
  ~InstanceOnStack() {
    if (!context_) return;
    context_->instID[0] = RTC_INVALID_GEOMETRY_ID;
    context_->instStackSize = 0;
  }
  InstanceOnStack(const InstanceOnStack&) = delete;
  InstanceOnStack& operator=(const InstanceOnStack&) = delete;

 private:
  RTCPointQueryContext* const context_;
};

float OnCandidate(void* data, const PointCandidate& candidate) {
  auto& call = *static_cast<Call*>(candidate.call);
  const RTCPointQueryFunction own = static_cast<const Geometry*>(data)->callbacks().point_query;
  if (!call.function && !own) return candidate.radius;
  const InstanceOnStack instance(call.context, candidate.instance);
  RTCPointQueryFunctionArguments args;
  args.query = &call.query;
  args.userPtr = call.user_pointer;
  args.primID = candidate.primitive_id;
  args.geomID = candidate.geometry_id;
  args.context = &call.context;
  args.similarityScale =
      candidate.instance ? candidate.instance->similarity_scale : call.similarity_scale;
  bool changed = false;
  if (call.function) changed |= call.function(&args);
  if (own) changed |= own(&args);
  call.changed |= changed;
  return changed ? call.query.radius : candidate.radius;
}

}  // namespace

PointCallback PointCallbackOf(Geometry& geometry) { return {OnCandidate, &geometry}; }

bool RunPointQuery(const dacrt::Scene& scene, RTCPointQuery& query, RTCPointQueryContext& context,
                   RTCPointQueryFunction function, void* user_pointer) {
  if (context.instStackSize > RTC_MAX_INSTANCE_LEVEL_COUNT) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "context->instStackSize = ", context.instStackSize,
                   " is larger than ", RTC_MAX_INSTANCE_LEVEL_COUNT);
  }
  Call call{query, context, function, user_pointer, 1};
  AffineTransform to_scene;
  if (context.instStackSize > 0) {
    to_scene = ReadTransform(kMatrix, context.world2inst[context.instStackSize - 1]).matrix;
    call.similarity_scale = SimilarityScale(to_scene);
  }
  PointQuery engine_query;
  engine_query.point[0] = query.x;
  engine_query.point[1] = query.y;
  engine_query.point[2] = query.z;
  engine_query.radius = query.radius;
  engine_query.time = query.time;
  engine_query.to_scene = context.instStackSize > 0 ? &to_scene : nullptr;
  engine_query.call = &call;
  scene.QueryPoint(engine_query);
  return call.changed;
}

}  // namespace dacrt::compat
