// The building: floor, walls, columns, vaults, windows, door and staircase.
#pragma once

#include "scenes/mesh_builder.h"

namespace scenes {

// The plan, in metres. The hall lies along x, centred; the nave between the columns, an aisle on
// either side.
inline constexpr int kBays = 6;
inline constexpr double kBay = 6;  // along x, from column to column
inline constexpr double kHallHalfLength = kBays * kBay / 2;
inline constexpr double kColumnLine = 4.5;       // z of the axes of the columns
inline constexpr double kArcadeThickness = 0.8;  // of the wall that they carry
inline constexpr double kNaveWall = kColumnLine - kArcadeThickness / 2;
inline constexpr double kAisleWall = 8.5;        // z of the inner face
inline constexpr double kStairFoot = 8.6;        // x
inline constexpr double kPlatform = 2.24;        // its height, at the head of the stairs
inline constexpr double kPlatformFront = 13.08;  // x
inline constexpr double kNaveVaultSpring = 8.2;
inline constexpr double kNaveVaultRise = 3.6;

// x of the middle of a bay, counted from the entrance.
inline double BayCentre(int bay) { return kBay * (bay + 0.5) - kHallHalfLength; }
// x of the columns at the start of a bay.
inline double BayStart(int bay) { return kBay * bay - kHallHalfLength; }

// One side of the hall: local z is the distance from the middle.
inline Frame Side(int sign) { return Frame().Scaled(1, 1, sign); }

void BuildArchitecture(MeshBuilder& builder);

}  // namespace scenes
