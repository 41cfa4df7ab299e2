/* The least program: one triangle, four rays, one call. */
#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>

int main(void) {
  RTCDevice device = rtcNewDevice(NULL);
  RTCScene scene = rtcNewScene(device);

  RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* vertices = rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            3 * sizeof(float), 3);
  unsigned* indices = rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(unsigned), 1);
  const float corners[9] = {0, 0, 0, 4, 0, 0, 0, 4, 0};
  for (int i = 0; i < 9; ++i) vertices[i] = corners[i];
  for (int i = 0; i < 3; ++i) indices[i] = i;
  rtcCommitGeometry(triangle);
  rtcAttachGeometry(scene, triangle);
  rtcReleaseGeometry(triangle);
  rtcCommitScene(scene);

  enum { kRays = 4 };
  struct RTCRayHit rays[kRays] = {0};
  for (int i = 0; i < kRays; ++i) {
    rays[i].ray.org_x = rays[i].ray.org_y = 0.5f + i; /* along the diagonal, 2 above the plane */
    rays[i].ray.org_z = 2;
    rays[i].ray.dir_z = -1;
    rays[i].ray.tfar = INFINITY;
    rays[i].ray.mask = -1;
    rays[i].hit.geomID = RTC_INVALID_GEOMETRY_ID;
  }
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1M(scene, &context, rays, kRays, sizeof(rays[0]));

  for (int i = 0; i < kRays; ++i) {
    if (rays[i].hit.geomID == RTC_INVALID_GEOMETRY_ID) {
      printf("ray %d misses\n", i);
    } else {
      printf("ray %d hits triangle %u at t = %g, u = %g, v = %g\n", i, rays[i].hit.primID,
             rays[i].ray.tfar, rays[i].hit.u, rays[i].hit.v);
    }
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}
