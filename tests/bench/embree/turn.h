// Where instances stand.
#pragma once

#include <Imath/ImathVec.h>

#include "scene_content.h"

namespace dacrt::bench {

/// Turned by so many degrees about the y axis through `middle`.
Transform TurnAbout(const Imath::V3f& middle, float degrees);

}  // namespace dacrt::bench
