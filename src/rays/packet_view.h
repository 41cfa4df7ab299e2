// A packet as a view of rays, for code that does not care which it is.
#pragma once

#include "dacrt/ray_view.h"

namespace dacrt {

/// Its rays are the lanes, also those that take no part.
RayView ViewOf(const RayPacket& packet);

}  // namespace dacrt
