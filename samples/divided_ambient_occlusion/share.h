// The part of the hall that one rank holds.
#pragma once

#include <cstdint>

#include "scenes/hall.h"

namespace divided {

// The triangles of `hall` whose middle lies in slice `rank` of `ranks` across its long axis, as
// many in each slice, with the vertices that they need. Walls are a few long triangles, which would
// stretch the bounds of a slice over the whole hall: they are cut before, which changes no picture.
scenes::Mesh TakeShare(scenes::Mesh hall, uint32_t rank, uint32_t ranks);

}  // namespace divided
