// Values of vertex buffers between the vertices: rtcInterpolate for triangle, quad and grid meshes.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>

namespace dacrt::compat {

class Geometry;

/// Where results go; null for what is not wanted.
struct InterpolationOutput {
  float* value;
  float* along_u;  ///< derivatives
  float* along_v;
  float* along_uu;
  float* along_vv;
  float* along_uv;
};

/// Writes `count` values at (u, v) on a primitive, `stride` floats apart.
/// Throws RTC_ERROR_INVALID_OPERATION for other geometries, RTC_ERROR_INVALID_ARGUMENT where there
/// is no such buffer, or the primitive or one of its vertices is not in the buffers.
void Interpolate(const Geometry& geometry, unsigned int primitive, float u, float v,
                 RTCBufferType type, unsigned int slot, unsigned int count, std::size_t stride,
                 const InterpolationOutput& output);

}  // namespace dacrt::compat
