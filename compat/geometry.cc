#include "geometry.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "boundary.h"
#include "device.h"
#include "names.h"
#include "point_query.h"
#include "scene.h"

namespace dacrt::compat {
namespace {

bool IsSupported(RTCGeometryType type) {
  switch (type) {
    case RTC_GEOMETRY_TYPE_TRIANGLE:
    case RTC_GEOMETRY_TYPE_QUAD:
    case RTC_GEOMETRY_TYPE_GRID:
    case RTC_GEOMETRY_TYPE_SPHERE_POINT:
    case RTC_GEOMETRY_TYPE_DISC_POINT:
    case RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT:
    case RTC_GEOMETRY_TYPE_USER:
    case RTC_GEOMETRY_TYPE_INSTANCE:
      return true;
    default:
      return false;
  }
}

Shape ShapeOf(RTCGeometryType type) {
  switch (type) {
    case RTC_GEOMETRY_TYPE_QUAD:
      return Shape::kQuads;
    case RTC_GEOMETRY_TYPE_GRID:
      return Shape::kGrids;
    case RTC_GEOMETRY_TYPE_SPHERE_POINT:
      return Shape::kSpheres;
    case RTC_GEOMETRY_TYPE_DISC_POINT:
      return Shape::kDiscs;
    case RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT:
      return Shape::kOrientedDiscs;
    case RTC_GEOMETRY_TYPE_USER:
      return Shape::kUser;
    case RTC_GEOMETRY_TYPE_INSTANCE:
      return Shape::kInstance;
    default:
      return Shape::kTriangles;
  }
}

/// As in Embree, points take no part in point queries, and of an instance its geometries do.
bool TakesPointQueries(RTCGeometryType type) {
  return type == RTC_GEOMETRY_TYPE_TRIANGLE || type == RTC_GEOMETRY_TYPE_QUAD ||
         type == RTC_GEOMETRY_TYPE_GRID || type == RTC_GEOMETRY_TYPE_USER;
}

}  // namespace

Geometry::Geometry(std::shared_ptr<Device> device, RTCGeometryType type)
    : device_(std::move(device)), type_(type), buffers_(device_, type) {
  if (IsSupported(type)) return;
  const char* const name = Name(type);
  if (!name) {
    throw ApiError(RTC_ERROR_UNKNOWN, "type = ", static_cast<int>(type), " is no geometry type");
  }
  throw ApiError(RTC_ERROR_INVALID_OPERATION, "type = ", static_cast<int>(type), " (", name,
                 ") is not supported by dacrt");
}

Geometry::~Geometry() { HandleTable<Geometry>::Instance().Forget(this); }

void Geometry::Commit() {
  if (time_steps_ == 0) throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry has no time steps");
  if (!IsInstance()) {  // which has no buffers in which something may have changed
    buffers_.CheckForCommit();
    ++changes_;
    static std::atomic<uint64_t> last_revision{0};
    revision_ = ++last_revision;
  }
  is_modified_ = false;
  ++version_;
}

uint64_t Geometry::version() const {
  // Both only grow, and with another scene version_ by what it counted for.
  return instanced_scene_ ? version_ + instanced_scene_->commit_count() : version_;
}

uint64_t Geometry::description_version() const {
  // As above: SetInstancedScene counts too.
  return instanced_scene_ ? changes_ + instanced_scene_->commit_count() : changes_;
}

void Geometry::SetEnabled(bool enabled) {
  if (is_enabled_ == enabled) return;
  is_enabled_ = enabled;
  ++version_;
}

void Geometry::SetMask(uint32_t mask) {
  mask_ = mask;
  SetModified();
}

void Geometry::SetBuildQuality(RTCBuildQuality quality) {
  // There is nothing to build, but REFIT says how scenes are to take changes.
  if (quality < RTC_BUILD_QUALITY_LOW || quality > RTC_BUILD_QUALITY_REFIT) {
    throw ApiError(RTC_ERROR_UNKNOWN, "quality = ", static_cast<int>(quality),
                   " is no build quality");
  }
  build_quality_ = quality;
  SetModified();
}

void Geometry::SetTimeStepCount(unsigned int count) {
  if (count > RTC_MAX_TIME_STEP_COUNT) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "timeStepCount = ", count, " is larger than ",
                   RTC_MAX_TIME_STEP_COUNT);
  }
  if (count == time_steps_) return;
  time_steps_ = count;
  buffers_.SetTimeStepCount(count);
  transforms_.resize(count);
  SetModified();
}

void Geometry::SetTimeRange(float start, float end) {
  if (start > end) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "startTime = ", start, " is after endTime = ", end);
  }
  time_range_ = {start, end};
  SetModified();
}

void Geometry::SetVertexAttributeCount(unsigned int count) {
  buffers_.SetVertexAttributeCount(count);
  SetModified();
}

void Geometry::UpdateBuffer(RTCBufferType type, unsigned int slot) {
  // Embree says nothing where there are no buffers.
  if (!IsUser() && !IsInstance()) buffers_.View(type, slot);
  SetModified();
}

void Geometry::CheckMayFilter() const {
  if (IsInstance()) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry is an instance, which has no filter");
  }
}

void Geometry::CheckIsUser() const {
  if (!IsUser()) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry is a ", Name(type_),
                   ", not a user geometry");
  }
}

void Geometry::CheckIsInstance() const {
  if (!IsInstance()) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry is a ", Name(type_), ", not an instance");
  }
}

void Geometry::SetClosestFilter(RTCFilterFunctionN filter) {
  CheckMayFilter();
  callbacks_.closest_filter = filter;
  ++changes_;
}

void Geometry::SetAnyFilter(RTCFilterFunctionN filter) {
  CheckMayFilter();
  callbacks_.any_filter = filter;
  ++changes_;
}

void Geometry::SetUserPrimitiveCount(unsigned int count) {
  CheckIsUser();
  if (count == user_primitives_) return;
  user_primitives_ = count;
  SetModified();
}

void Geometry::SetBoundsFunction(RTCBoundsFunction function) {
  CheckIsUser();
  callbacks_.bounds = function;
  ++changes_;
}

void Geometry::SetIntersectFunction(RTCIntersectFunctionN function) {
  CheckIsUser();
  callbacks_.intersect = function;
  ++changes_;
}

void Geometry::SetOccludedFunction(RTCOccludedFunctionN function) {
  CheckIsUser();
  callbacks_.occluded = function;
  ++changes_;
}

void Geometry::SetPointQueryFunction(RTCPointQueryFunction function) {
  callbacks_.point_query = function;
  ++changes_;
}

void Geometry::SetInstancedScene(std::shared_ptr<Scene> scene) {
  CheckIsInstance();
  if (scene->device() != device_) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "geometry and scene are from different devices");
  }
  if (scene->LeadsTo(this)) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "scene would be an instance in itself");
  }
  version_ = version();
  changes_ = description_version();
  instanced_scene_ = std::move(scene);
  SetModified();
}

void Geometry::SetTransform(unsigned int time_step, const TransformStep& transform) {
  CheckIsInstance();
  if (time_step >= transforms_.size()) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "timeStep = ", time_step,
                   " is not below the number of time steps, which is ", transforms_.size());
  }
  transforms_[time_step] = transform;
  ++placements_;
}

AffineTransform Geometry::TransformAt(float time) const {
  CheckIsInstance();
  if (transforms_.empty()) {
    throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry has no time steps");
  }
  return dacrt::TransformAt(transforms_, time_range_, time);
}

const char* Geometry::Lack() const {
  if (IsInstance() && !instanced_scene_) return "instanced scene";
  if (IsUser() && user_primitives_ > 0 && !callbacks_.bounds) return "bounds function";
  return nullptr;
}

dacrt::Geometry Geometry::Describe(uint32_t geometry_id, bool context_filter) {
  dacrt::Geometry description;
  description.shape = ShapeOf(type_);
  description.geometry_id = geometry_id;
  description.mask = device_->ignore_masks() ? UINT32_MAX : mask_;
  description.time_range = time_range_;
  SetCallbacks(*this, context_filter, description);
  if (TakesPointQueries(type_)) description.point_callback = PointCallbackOf(*this);
  if (IsInstance()) {
    description.transforms = transforms_;
    description.instanced_scene = instanced_scene_->CommittedShared();
    description.primitive_count = description.instanced_scene ? 1 : 0;
  } else if (IsUser()) {
    description.user_time_steps = time_steps_;
    description.primitive_count = user_primitives_;
  } else {
    buffers_.Describe(description);
    description.revision = revision_;
  }
  return description;
}

}  // namespace dacrt::compat
