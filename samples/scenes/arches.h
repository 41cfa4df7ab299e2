// Walls with arched openings, and what stands in and around these.
#pragma once

#include "scenes/mesh_builder.h"

namespace scenes {

// A wall along x, centred at the origin, with an opening under a round arch. The opening reaches
// down to the sill, or to the foot of the wall.
struct ArchedPanel {
  double half_width;
  double low;
  double high;
  double thickness;
  double opening;  // half its width
  double sill;
  double spring;
};

void ArchedWall(MeshBuilder& builder, const Frame& frame, const ArchedPanel& wall);

// A half circle of round moulding round an arch, standing on the origin.
void Archivolt(MeshBuilder& builder, const Frame& frame, double arch, double margin,
               double thickness);

// Iron bars in an arched opening.
void Grille(MeshBuilder& builder, const Frame& frame, double opening, double sill, double spring);

// Stone circles under the arch of a tall window, and the mullions that carry them.
void Tracery(MeshBuilder& builder, const Frame& frame, double opening, double sill, double spring);

}  // namespace scenes
