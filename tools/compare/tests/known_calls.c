/* usage: known_calls MODE
 * Makes calls of Embree 3, of which compare_test.cc knows how many. MODE is
 *   all      every counted form of call, and a ray from within a filter function
 *   crash    the same, and ends by a signal
 *   dacrt    the same with dacrt; fails with Embree
 *   embree   the same with Embree; fails with dacrt
 *   curves   asks for a geometry that dacrt does not have, and goes on without it */
#include <embree3/rtcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static RTCScene scene;
static int nested;

static struct RTCRayHit make_ray(void) {
  struct RTCRayHit ray;
  memset(&ray, 0, sizeof ray);
  ray.ray.org_x = ray.ray.org_y = 0.25f;
  ray.ray.org_z = -1;
  ray.ray.dir_z = 1;
  ray.ray.tfar = INFINITY;
  ray.ray.mask = (unsigned)-1;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return ray;
}

static void filter(const struct RTCFilterFunctionNArguments* arguments) {
  struct RTCIntersectContext context;
  struct RTCRayHit ray = make_ray();
  (void)arguments;
  if (nested) return;
  nested = 1;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray.ray);
  nested = 0;
}

static void commit(RTCDevice device) {
  static const float vertices[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0};
  static const unsigned indices[3] = {0, 1, 2};
  RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  scene = rtcNewScene(device);
  rtcSetSharedGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                             12, 3);
  rtcSetSharedGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12,
                             1);
  rtcSetGeometryIntersectFilterFunction(triangle, filter);
  rtcCommitGeometry(triangle);
  rtcAttachGeometry(scene, triangle);
  rtcReleaseGeometry(triangle);
  rtcCommitScene(scene);
}

enum { kMany = 5000 };

static void trace(void) {
  static int valid[16] = {-1, 0, -1, -1};
  struct RTCRayHit* rays = malloc(kMany * sizeof *rays);
  struct RTCIntersectContext context;
  struct RTCRay16 packet;
  struct RTCRayHit ray = make_ray();
  int i;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray); /* and one from within the filter function */
  for (i = 0; i < 10; ++i) {
    ray = make_ray();
    rtcOccluded1(scene, &context, &ray.ray);
  }
  memset(&packet, 0, sizeof packet);
  rtcOccluded16(valid, scene, &context, &packet); /* three rays */
  for (i = 0; i < kMany; ++i) rays[i] = make_ray();
  nested = 1; /* the filter function leaves it at that */
  rtcIntersect1M(scene, &context, rays, 64, sizeof *rays);
  rtcIntersect1M(scene, &context, rays, 65, sizeof *rays);
  rtcIntersect1M(scene, &context, rays, kMany, sizeof *rays);
  rtcOccluded1M(scene, &context, &rays->ray, 1024, sizeof *rays);
  nested = 0;
  free(rays);
}

int main(int argc, char** argv) {
  const char* mode = argc > 1 ? argv[1] : "";
  RTCDevice device = rtcNewDevice("dacrt_nonsense=1"); /* dacrt refuses it, Embree does not look */
  const int is_dacrt = !device;
  if (!device) device = rtcNewDevice(NULL);
  if (strcmp(mode, is_dacrt ? "embree" : "dacrt") == 0) {
    fprintf(stderr, "the wrong library\n\n");
    return 3;
  }
  if (strcmp(mode, "curves") == 0) {
    RTCGeometry curves = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE);
    if (curves) rtcReleaseGeometry(curves);
  }
  commit(device);
  trace();
  printf("traced\n");
  fflush(stdout);
  if (strcmp(mode, "crash") == 0) abort();
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}
