// Embree's enumerators in messages.
#pragma once

#include <embree3/rtcore.h>

namespace dacrt::compat {

/// What geometries of this type are called, e.g. "quad mesh"; null for no type of Embree's.
const char* Name(RTCGeometryType type);

/// The enumerator without its prefix, e.g. "VERTEX_ATTRIBUTE"; "unknown" for none of Embree's.
const char* Name(RTCBufferType type);

}  // namespace dacrt::compat
