// rtcore_geometry.h: interpolation. Programs call it once a hit, so the geometry's handle is
// trusted, as in a query.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"
#include "interpolate.h"
#include "names.h"

using namespace dacrt::compat;

namespace {

/// Runs `body` on the geometry that `args` names.
template <class Arguments, class Body>
void OnGeometryOf(const char* function, const Arguments* args, Body&& body) {
  const Geometry* const geometry = args ? ToObject(args->geometry) : nullptr;
  Guarded(function, geometry ? geometry->device().get() : nullptr, [&] {
    CheckPointer(args, "args");
    CheckPointer(geometry, "args->geometry");
    body(*geometry);
  });
}

/// The buffer whose values are interpolated.
const BufferView& DataOf(const Geometry& geometry, RTCBufferType type, unsigned int slot) {
  if (type != RTC_BUFFER_TYPE_VERTEX && type != RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "bufferType = ", static_cast<int>(type), " (",
                   Name(type), ") is neither VERTEX nor VERTEX_ATTRIBUTE");
  }
  return geometry.buffers().View(type, slot);
}

InterpolationPoint PointIn(const Geometry& geometry, uint32_t primitive, float u, float v) {
  const auto primitives = [&](RTCBufferType type) -> const BufferView& {
    return geometry.buffers().View(type, 0);
  };
  switch (geometry.type()) {
    case RTC_GEOMETRY_TYPE_TRIANGLE:
      return PointInTriangle(primitives(RTC_BUFFER_TYPE_INDEX), primitive, u, v);
    case RTC_GEOMETRY_TYPE_QUAD:
      return PointInQuad(primitives(RTC_BUFFER_TYPE_INDEX), primitive, u, v);
    case RTC_GEOMETRY_TYPE_GRID:
      return PointInGrid(primitives(RTC_BUFFER_TYPE_GRID), primitive, u, v);
    default:
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "geometry is a ", Name(geometry.type()),
                     ", over which nothing is interpolated");
  }
}

}  // namespace

RTC_API void rtcInterpolate(const RTCInterpolateArguments* args) {
  OnGeometryOf(__func__, args, [&](const Geometry& geometry) {
    const InterpolationPoint point = PointIn(geometry, args->primID, args->u, args->v);
    Interpolate(DataOf(geometry, args->bufferType, args->bufferSlot), point, args->valueCount,
                {args->P, args->dPdu, args->dPdv, args->ddPdudu, args->ddPdvdv, args->ddPdudv, 1});
  });
}

RTC_API void rtcInterpolateN(const RTCInterpolateNArguments* args) {
  OnGeometryOf(__func__, args, [&](const Geometry& geometry) {
    constexpr unsigned int kMostValues = 256;  // Embree's
    if (args->valueCount > kMostValues) {
      throw ApiError(RTC_ERROR_INVALID_OPERATION, "valueCount = ", args->valueCount,
                     " is larger than ", kMostValues);
    }
    const auto* const valid = static_cast<const int*>(args->valid);
    for (unsigned int i = 0; i < args->N; ++i) {
      if (valid && valid[i] == 0) continue;
      const InterpolationPoint point = PointIn(geometry, args->primIDs[i], args->u[i], args->v[i]);
      const auto lane = [&](float* values) { return values ? values + i : nullptr; };
      Interpolate(DataOf(geometry, args->bufferType, args->bufferSlot), point, args->valueCount,
                  {lane(args->P), lane(args->dPdu), lane(args->dPdv), lane(args->ddPdudu),
                   lane(args->ddPdvdv), lane(args->ddPdudv), args->N});
    }
  });
}
