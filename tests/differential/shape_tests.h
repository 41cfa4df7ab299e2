// What is true of a ray and a shape whose numbers are known up to rounding, and what single
// precision may make of it; as reference.h for triangles with exact numbers.
#pragma once

#include <vector>

#include "motion.h"

namespace dacrt::tests {

/// Whether a hit, and where. The values have infinite errors where nothing is known of them.
using ShapeAnswer = TriangleAnswer;

/// The test of Moeller and Trumbore, which both libraries use where scenes are not robust.
ShapeAnswer TestFacet(const ApproximateRay& ray, const Approximate3& v0, const Approximate3& v1,
                      const Approximate3& v2);

/// The test of the volumes of edge and ray, for robust scenes: edges belong to the facets on both
/// sides.
ShapeAnswer TestFacetRobustly(const ApproximateRay& ray, const Approximate3& v0,
                              const Approximate3& v1, const Approximate3& v2);

/// The near and the far hit.
std::vector<ShapeAnswer> TestSphere(const ApproximateRay& ray, const ApproximateVertex& sphere);

ShapeAnswer TestDisc(const ApproximateRay& ray, const ApproximateVertex& disc);

ShapeAnswer TestOrientedDisc(const ApproximateRay& ray, const ApproximateVertex& disc,
                             const Approximate3& normal);

}  // namespace dacrt::tests
