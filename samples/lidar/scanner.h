// A laser scanner on a roof: beams that lie over each other turn about an axis while it drives.
#pragma once

#include <Imath/ImathVec.h>

#include <cstdint>
#include <span>
#include <vector>

#include "dacrt/dacrt.h"

namespace lidar {

inline constexpr float kRange = 100;          // metres
inline constexpr float kSecondsASweep = 0.4;  // slow, as those are that draw maps
inline constexpr float kSpeed = 12;           // metres a second
inline constexpr uint32_t kBeams = 64;

struct Point {
  Imath::V3f position;
  uint8_t intensity;  // of the light that came back: the steeper and nearer, the more
  uint8_t geometry;
};

// Where the scanner is, seconds after its start.
Imath::V3f ScannerAt(float seconds);

// The rays of a sweep, in the order in which they are shot: `count`, or what fills all beams.
std::vector<dacrt::RayHit> MakeSweep(uint32_t sweep, uint32_t count);

// Adds the points that the rays have hit.
void AddPoints(std::span<const dacrt::RayHit> rays, std::vector<Point>* points);

}  // namespace lidar
