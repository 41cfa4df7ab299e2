// Where the vertices of a geometry and an instance's scene are at a ray's time, as single precision
// may compute it.
#pragma once

#include <cstdint>

#include "approximate.h"
#include "world.h"

namespace dacrt::tests {

/// A ray of which a library knows the numbers up to rounding only.
struct ApproximateRay {
  Approximate3 org, dir;
  double tnear = 0, tfar = 0;
};

/// The ray as it is in the record.
ApproximateRay Exactly(const RTCRay& ray);

/// A time between two time steps.
struct Moment {
  uint32_t step = 0;
  Approximate fraction;
  bool is_there = true;      ///< the time lies in the geometry's range
  bool is_doubtful = false;  ///< it lies at an end of the range within rounding
};

Moment MomentAt(const WorldGeometry& geometry, float time);

struct ApproximateVertex {
  Approximate3 position;
  Approximate radius;
};

ApproximateVertex VertexAt(const WorldGeometry& geometry, uint32_t vertex, const Moment& moment);
Approximate3 NormalAt(const WorldGeometry& geometry, uint32_t vertex, const Moment& moment);

struct ApproximateTransform {
  Approximate3 column[4];
};

/// From the instanced scene's space to the world.
ApproximateTransform ToWorld(const WorldGeometry& instance, const Moment& moment);

/// The ray in the instanced scene's space.
ApproximateRay ToInstance(const ApproximateRay& ray, const ApproximateTransform& to_world);

}  // namespace dacrt::tests
