// Point queries of the API: its structures and functions on the engine's.
#pragma once

#include <embree3/rtcore.h>

#include "dacrt/dacrt.h"

namespace dacrt::compat {

class Geometry;

/// Makes the engine call the program's functions for the primitives of `geometry`: the one that
/// RunPointQuery is called with, and then the geometry's own. Which ones there are is decided when
/// they are called, as in Embree.
PointCallback PointCallbackOf(Geometry& geometry);

/// Calls `function`, which may be null, and the geometries' own for the primitives within the
/// query's radius, which they may shrink. True if one of them said that it did.
/// Throws RTC_ERROR_INVALID_ARGUMENT for a stack that is no instance stack.
bool RunPointQuery(const dacrt::Scene& scene, RTCPointQuery& query, RTCPointQueryContext& context,
                   RTCPointQueryFunction function, void* user_pointer);

}  // namespace dacrt::compat
