#include "callbacks.h"

#include <cmath>
#include <limits>

namespace dacrt::bench {
namespace {

constexpr unsigned kPrimitivesAHole = 8;

void LetThroughHoles(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    if (RTCHitN_primID(args->hit, args->N, i) % kPrimitivesAHole == 0) args->valid[i] = 0;
  }
}

void SphereBounds(const RTCBoundsFunctionArguments* args) {
  const Sphere& sphere = *static_cast<const Sphere*>(args->geometryUserPtr);
  RTCBounds& bounds = *args->bounds_o;
  bounds.lower_x = sphere.centre[0] - sphere.radius;
  bounds.lower_y = sphere.centre[1] - sphere.radius;
  bounds.lower_z = sphere.centre[2] - sphere.radius;
  bounds.upper_x = sphere.centre[0] + sphere.radius;
  bounds.upper_y = sphere.centre[1] + sphere.radius;
  bounds.upper_z = sphere.centre[2] + sphere.radius;
}

// The nearer of the two distances within the ray, or NaN.
float DistanceTo(const Sphere& sphere, RTCRayN* ray, unsigned n, unsigned i) {
  const float org[3] = {RTCRayN_org_x(ray, n, i) - sphere.centre[0],
                        RTCRayN_org_y(ray, n, i) - sphere.centre[1],
                        RTCRayN_org_z(ray, n, i) - sphere.centre[2]};
  const float dir[3] = {RTCRayN_dir_x(ray, n, i), RTCRayN_dir_y(ray, n, i),
                        RTCRayN_dir_z(ray, n, i)};
  float a = 0, b = 0, c = -sphere.radius * sphere.radius;
  for (int axis = 0; axis < 3; ++axis) {
    a += dir[axis] * dir[axis];
    b += org[axis] * dir[axis];
    c += org[axis] * org[axis];
  }
  const float root = std::sqrt(b * b - a * c);  // NaN: beside it
  for (const float t : {(-b - root) / a, (-b + root) / a}) {
    if (t > RTCRayN_tnear(ray, n, i) && t < RTCRayN_tfar(ray, n, i)) return t;
  }
  return std::numeric_limits<float>::quiet_NaN();
}

void IntersectSphere(const RTCIntersectFunctionNArguments* args) {
  const Sphere& sphere = *static_cast<const Sphere*>(args->geometryUserPtr);
  const unsigned n = args->N;
  RTCRayN* const ray = RTCRayHitN_RayN(args->rayhit, n);
  RTCHitN* const hit = RTCRayHitN_HitN(args->rayhit, n);
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1) continue;
    const float t = DistanceTo(sphere, ray, n, i);
    if (std::isnan(t)) continue;
    RTCRayN_tfar(ray, n, i) = t;
    RTCHitN_Ng_x(hit, n, i) =
        RTCRayN_org_x(ray, n, i) + t * RTCRayN_dir_x(ray, n, i) - sphere.centre[0];
    RTCHitN_Ng_y(hit, n, i) =
        RTCRayN_org_y(ray, n, i) + t * RTCRayN_dir_y(ray, n, i) - sphere.centre[1];
    RTCHitN_Ng_z(hit, n, i) =
        RTCRayN_org_z(ray, n, i) + t * RTCRayN_dir_z(ray, n, i) - sphere.centre[2];
    RTCHitN_u(hit, n, i) = 0;
    RTCHitN_v(hit, n, i) = 0;
    RTCHitN_primID(hit, n, i) = args->primID;
    RTCHitN_geomID(hit, n, i) = args->geomID;
    RTCHitN_instID(hit, n, i, 0) = args->context->instID[0];
  }
}

void OccludeBySphere(const RTCOccludedFunctionNArguments* args) {
  const Sphere& sphere = *static_cast<const Sphere*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    if (std::isnan(DistanceTo(sphere, args->ray, args->N, i))) continue;
    RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
  }
}

}  // namespace

void SetSphereFunctions(const tests::EmbreeApi& api, RTCGeometry geometry, const void* sphere) {
  api.rtcSetGeometryUserPrimitiveCount(geometry, 1);
  api.rtcSetGeometryUserData(geometry, const_cast<void*>(sphere));
  api.rtcSetGeometryBoundsFunction(geometry, SphereBounds, nullptr);
  api.rtcSetGeometryIntersectFunction(geometry, IntersectSphere);
  api.rtcSetGeometryOccludedFunction(geometry, OccludeBySphere);
}

void SetFilterFunctions(const tests::EmbreeApi& api, RTCGeometry geometry) {
  api.rtcSetGeometryIntersectFilterFunction(geometry, LetThroughHoles);
  api.rtcSetGeometryOccludedFilterFunction(geometry, LetThroughHoles);
}

}  // namespace dacrt::bench
