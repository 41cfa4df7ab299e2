/* A C99 program on the drop-in: one triangle, one ray that hits it and one that misses. */
#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>

static int failures = 0;

static void check(int holds, const char* what) {
  if (!holds) {
    fprintf(stderr, "failed: %s\n", what);
    ++failures;
  }
}

static struct RTCRayHit ray_at(float x) {
  struct RTCRayHit record = {0};
  record.ray.org_x = x;
  record.ray.org_y = 0.25f;
  record.ray.org_z = -1;
  record.ray.dir_z = 1;
  record.ray.tfar = INFINITY;
  record.ray.mask = 0xFFFFFFFFu;
  record.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return record;
}

int main(void) {
  /* A name that only dacrt refuses proves that it is dacrt that answers. */
  check(!rtcNewDevice("dacrt_nonsense=1"), "an unknown dacrt_ key is refused");
  check(rtcGetDeviceError(NULL) == RTC_ERROR_INVALID_ARGUMENT, "as an invalid argument");

  RTCDevice device = rtcNewDevice(NULL);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* vertices = rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            3 * sizeof(float), 3);
  unsigned* indices = rtcSetNewGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(unsigned), 1);
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (int i = 0; i < 9; ++i) vertices[i] = corners[i];
  for (unsigned i = 0; i < 3; ++i) indices[i] = i;
  rtcCommitGeometry(triangle);
  rtcAttachGeometry(scene, triangle);
  rtcReleaseGeometry(triangle);
  rtcCommitScene(scene);

  struct RTCRayHit rays[2] = {ray_at(0.25f), ray_at(2)};
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1M(scene, &context, rays, 2, sizeof rays[0]);
  check(rays[0].hit.geomID == 0 && rays[0].hit.primID == 0, "the first ray hits the triangle");
  check(rays[0].ray.tfar == 1, "at distance 1");
  check(rays[1].hit.geomID == RTC_INVALID_GEOMETRY_ID, "the second one misses");
  check(rtcGetDeviceError(device) == RTC_ERROR_NONE, "no error");

  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return failures != 0;
}
