/* usage: app LIBRARY, which is "dacrt" or "embree": the library that the caller expects to answer.
 * Traces one ray against one triangle, and compares the library's features with the package's. */
#include <embree3/rtcore.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Embree passes over configuration that it does not know; dacrt refuses what begins with dacrt_ and
 * is none of its own. */
static const char* answering_library(void) {
  RTCDevice device = rtcNewDevice("dacrt_nonsense=1");
  if (!device) return "dacrt";
  rtcReleaseDevice(device);
  return "embree";
}

static int ray_hits(const char* library) {
  const float vertices[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0};
  const unsigned indices[3] = {0, 1, 2};
  RTCDevice device = rtcNewDevice(NULL);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices, 0,
                             12, 3);
  rtcSetSharedGeometryBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 0, 12,
                             1);
  rtcCommitGeometry(triangle);
  rtcAttachGeometry(scene, triangle);
  rtcReleaseGeometry(triangle);
  rtcCommitScene(scene);

  struct RTCRayHit ray;
  struct RTCIntersectContext context;
  memset(&ray, 0, sizeof ray);
  ray.ray.org_x = ray.ray.org_y = 0.25f;
  ray.ray.org_z = -1;
  ray.ray.dir_z = 1;
  ray.ray.tfar = 10;
  ray.ray.mask = 0xFFFFFFFFu;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcInitIntersectContext(&context);
  rtcIntersect1M(scene, &context, &ray, 1, sizeof ray);
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  /* Embree multiplies by an approximate reciprocal: on some processors this is 0.99999994. */
  const float off = strcmp(library, "embree") == 0 ? FLT_EPSILON : 0;
  return ray.hit.geomID == 0 && fabsf(ray.ray.tfar - 1) <= off;
}

#ifdef HAS_FEATURES
static int features_are_the_packages(void) {
  const struct {
    enum RTCDeviceProperty property;
    int value;
    const char* variable;
  } features[] = {
#include "features.inc"
  };
  int all_equal = 1;
  RTCDevice device = rtcNewDevice(NULL);
  for (unsigned i = 0; i < sizeof features / sizeof features[0]; ++i) {
    if (rtcGetDeviceProperty(device, features[i].property) == features[i].value) continue;
    fprintf(stderr, "%s = %d, the library says otherwise\n", features[i].variable,
            features[i].value);
    all_equal = 0;
  }
  rtcReleaseDevice(device);
  return all_equal;
}
#else
static int features_are_the_packages(void) { return 1; }
#endif

int main(int argc, char** argv) {
  const char* library = answering_library();
  if (argc != 2 || strcmp(argv[1], library) != 0) {
    fprintf(stderr, "%s answers\n", library);
    return 1;
  }
  if (!ray_hits(library)) {
    fprintf(stderr, "%s does not hit the triangle\n", library);
    return 2;
  }
  if (!features_are_the_packages()) return 3;
  return 0;
}
