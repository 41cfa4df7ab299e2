// A picture of the points.
#pragma once

#include <span>

#include "ambient_occlusion/image_file.h"
#include "lidar/scanner.h"

namespace lidar {

// The points from above the street, nearer ones before farther ones: blue at the ground, over green
// to red at the roofs, the van white, each as bright as the light that came back.
ao::Image DrawCloud(std::span<const Point> points, uint32_t width, uint32_t height);

}  // namespace lidar
