// The functions that a program gives to a library, where a kind of geometry has some.
#pragma once

#include "embree_api.h"

namespace dacrt::bench {

/// A user geometry of one primitive.
struct Sphere {
  float centre[3];
  float radius;
};

/// Makes `geometry` a user geometry that is the sphere, which must outlive it.
void SetSphereFunctions(const tests::EmbreeApi& api, RTCGeometry geometry, const void* sphere);

/// Filter functions that let rays through one primitive in eight, as a texture with holes does.
void SetFilterFunctions(const tests::EmbreeApi& api, RTCGeometry geometry);

}  // namespace dacrt::bench
