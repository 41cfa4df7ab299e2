// What stands, lies and hangs in the hall. Every piece is built in a frame of its own: y up from
// where it stands (or hangs), z towards whoever uses it.
#pragma once

#include "scenes/mesh_builder.h"

namespace scenes {

void Chair(MeshBuilder& builder, const Frame& frame);

// A table along x, laid for a feast, with its chairs.
void BanquetTable(MeshBuilder& builder, const Frame& frame, double length, uint32_t seed);

// Hangs from the frame's origin.
void Chandelier(MeshBuilder& builder, const Frame& frame, double drop);

// The back is the plane z = 0.
void Bookcase(MeshBuilder& builder, const Frame& frame, uint32_t seed);
void Chest(MeshBuilder& builder, const Frame& frame);

// On a pole that leans out of a wall along z.
void Banner(MeshBuilder& builder, const Frame& frame, uint32_t seed);

void PottedPlant(MeshBuilder& builder, const Frame& frame, uint32_t seed);
void ArmillarySphere(MeshBuilder& builder, const Frame& frame);
void KnotSculpture(MeshBuilder& builder, const Frame& frame);
void Vase(MeshBuilder& builder, const Frame& frame);

// Along x, with fringes at both ends.
void Carpet(MeshBuilder& builder, const Frame& frame, double length, double width);

}  // namespace scenes
