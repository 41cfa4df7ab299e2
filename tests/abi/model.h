// The smallest geometry of each type, the same for both libraries.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "session.h"

namespace dacrt::tests {

/// The types that the drop-in supports.
inline constexpr RTCGeometryType kSupportedTypes[] = {
    RTC_GEOMETRY_TYPE_TRIANGLE,   RTC_GEOMETRY_TYPE_QUAD,
    RTC_GEOMETRY_TYPE_GRID,       RTC_GEOMETRY_TYPE_SPHERE_POINT,
    RTC_GEOMETRY_TYPE_DISC_POINT, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT,
    RTC_GEOMETRY_TYPE_USER,       RTC_GEOMETRY_TYPE_INSTANCE,
};

std::string NameOf(RTCGeometryType type);
bool IsPoint(RTCGeometryType type);

/// Whether a geometry of this type is made of buffers.
bool HasBuffers(RTCGeometryType type);

/// Sets the buffers of one time step: vertices from (0, 0, z) to (1, 1, z), and normals where there
/// are any. Of more than four all others are at the origin. They lie `gap` bytes further apart than
/// they need.
void SetVertices(Session& s, RTCGeometry geometry, RTCGeometryType type, unsigned int slot,
                 float z = 0, std::size_t count = 4, std::size_t gap = 0);

/// Sets the buffer that says what the primitives are, of types that have one. They are all the
/// same.
void SetPrimitives(Session& s, RTCGeometry geometry, RTCGeometryType type, std::size_t count = 1);

/// A geometry of one primitive, or of four points, which the ray of RayAt(0.2) hits: at z = 0, but
/// spheres, whose radius is 1, earlier. Not committed.
RTCGeometry UncommittedModel(Session& s, RTCGeometryType type);
RTCGeometry Model(Session& s, RTCGeometryType type);

/// `count` triangles of this size at random places in the unit cube. Not committed.
RTCGeometry UncommittedSoup(Session& s, unsigned int seed, unsigned int count, float size);

/// Rays from below the unit cube into it, and some beside it.
std::vector<RTCRayHit> RandomRays(unsigned int seed, std::size_t count);

/// Functions of a user geometry. Its bounds are the box from (0, 0, 0) to (1, 1, 1); it is hit
/// where z is 0, with u = 0.5.
void BoundUnitBox(const RTCBoundsFunctionArguments* args);
void IntersectPlane(const RTCIntersectFunctionNArguments* args);
void OccludePlane(const RTCOccludedFunctionNArguments* args);

/// An instance of `scene`, moved by `z`. Not committed.
RTCGeometry Instance(Session& s, RTCScene scene, float z = 0);

}  // namespace dacrt::tests
