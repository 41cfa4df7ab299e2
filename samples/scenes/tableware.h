// What lies and stands on tables. See furniture.h.
#pragma once

#include "scenes/mesh_builder.h"

namespace scenes {

void Plate(MeshBuilder& builder, const Frame& frame);
void Goblet(MeshBuilder& builder, const Frame& frame);
void Cutlery(MeshBuilder& builder, const Frame& frame);

// An arm along z that rises to a saucer with a candle.
void CandleArm(MeshBuilder& builder, const Frame& frame, double reach, double rise);
void Candelabrum(MeshBuilder& builder, const Frame& frame);

void FruitBowl(MeshBuilder& builder, const Frame& frame, uint32_t seed);
void Jug(MeshBuilder& builder, const Frame& frame);
void OpenBook(MeshBuilder& builder, const Frame& frame);

}  // namespace scenes
