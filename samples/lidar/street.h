// A street: houses on both sides, trees, lamp posts, and a van that drives along it.
#pragma once

#include <Imath/ImathVec.h>

#include "scenes/hall.h"

namespace lidar {

inline constexpr float kStreetLength = 120;  // metres, along x from 0; y is up, the ground at 0

enum GeometryId : uint32_t { kStreet, kVan };

// Everything that stands still. The same for the same seed.
scenes::Mesh MakeStreet(uint32_t seed);

// The van, its rear axle at the origin, driving towards x.
scenes::Mesh MakeVan();

// Puts `mesh`, which has as many vertices as `model`, where the model is after it has moved.
void Place(const scenes::Mesh& model, const Imath::V3f& at, scenes::Mesh* mesh);

}  // namespace lidar
