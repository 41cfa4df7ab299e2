// Transforms in the formats of the API.
#pragma once

#include <embree3/rtcore.h>

#include "dacrt/transform.h"

namespace dacrt::compat {

/// Throw RTC_ERROR_INVALID_OPERATION for formats that are none of a transform.
TransformStep ReadTransform(RTCFormat format, const float* values);
void WriteTransform(const AffineTransform& transform, RTCFormat format, float* values);

TransformStep ReadTransform(const RTCQuaternionDecomposition& decomposition);

}  // namespace dacrt::compat
