// Where instances are.
#pragma once

#include <span>

#include "dacrt/transform.h"
#include "geometry/box.h"

namespace dacrt {

/// Bounds of an instance of what `box` holds, at each time step: between two of them lie those of
/// the times between. Empty where it is too far away.
void BoundInstance(std::span<const TransformStep> transforms, const Box& box, Box* bounds);

/// Into the instance, where it stands at the first time step.
AffineTransform ToFirstStep(std::span<const TransformStep> transforms);

}  // namespace dacrt
