// Interpolation of vertex data over a primitive.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>
#include <cstdint>

#include "buffer.h"

namespace dacrt::compat {

/// Where a point of a primitive stands: between three vertices, at
///   (1 - u - v) a + u b + v c.
struct InterpolationPoint {
  uint32_t a, b, c;
  float u, v;
  bool turned = false;          ///< u and v run against the primitive's
  float columns = 1, rows = 1;  ///< of the grid, whose derivatives Embree divides by them
};

/// The point (u, v) of a primitive; `primitives` is the buffer that describes them.
/// Throw RTC_ERROR_INVALID_ARGUMENT if there is no such primitive.
InterpolationPoint PointInTriangle(const BufferView& primitives, uint32_t primitive, float u,
                                   float v);
InterpolationPoint PointInQuad(const BufferView& primitives, uint32_t primitive, float u, float v);
/// Clamps u and v to [0, 1].
InterpolationPoint PointInGrid(const BufferView& primitives, uint32_t primitive, float u, float v);

/// Where values go, value i at [i * stride]. Each may be null. As in Embree, nothing goes to dpdv
/// without dpdu, nor to the other two second derivatives without ddpdudu.
struct InterpolationOutput {
  float* p;
  float* dpdu;
  float* dpdv;
  float* ddpdudu;
  float* ddpdvdv;
  float* ddpdudv;
  std::size_t stride;
};

/// Interpolates the first `value_count` floats of each of the three vertices' items in `data`.
/// Throws RTC_ERROR_INVALID_ARGUMENT, and writes nothing, if `data` does not have these items.
void Interpolate(const BufferView& data, const InterpolationPoint& point, std::size_t value_count,
                 const InterpolationOutput& output);

}  // namespace dacrt::compat
