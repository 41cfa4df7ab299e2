// Embree's functions, taken from a library that is opened at run time, so that the real Embree and
// the drop-in, which export the same names, can be called side by side in one process.
#pragma once

#include <embree3/rtcore.h>

#include <string>

namespace dacrt::tests {

/// Every function that the tests call, each named once.
#define DACRT_TESTS_EMBREE_FUNCTIONS(X)    \
  X(rtcNewDevice)                          \
  X(rtcReleaseDevice)                      \
  X(rtcGetDeviceError)                     \
  X(rtcSetDeviceMemoryMonitorFunction)     \
  X(rtcNewBuffer)                          \
  X(rtcGetBufferData)                      \
  X(rtcReleaseBuffer)                      \
  X(rtcNewScene)                           \
  X(rtcReleaseScene)                       \
  X(rtcCommitScene)                        \
  X(rtcSetSceneFlags)                      \
  X(rtcSetSceneBuildQuality)               \
  X(rtcGetSceneBounds)                     \
  X(rtcNewGeometry)                        \
  X(rtcReleaseGeometry)                    \
  X(rtcCommitGeometry)                     \
  X(rtcEnableGeometry)                     \
  X(rtcDisableGeometry)                    \
  X(rtcSetGeometryMask)                    \
  X(rtcSetGeometryBuildQuality)            \
  X(rtcSetGeometryTimeStepCount)           \
  X(rtcSetGeometryTimeRange)               \
  X(rtcSetGeometryUserData)                \
  X(rtcSetGeometryBuffer)                  \
  X(rtcSetSharedGeometryBuffer)            \
  X(rtcSetNewGeometryBuffer)               \
  X(rtcUpdateGeometryBuffer)               \
  X(rtcSetGeometryIntersectFilterFunction) \
  X(rtcSetGeometryOccludedFilterFunction)  \
  X(rtcSetGeometryUserPrimitiveCount)      \
  X(rtcSetGeometryBoundsFunction)          \
  X(rtcSetGeometryIntersectFunction)       \
  X(rtcSetGeometryOccludedFunction)        \
  X(rtcFilterIntersection)                 \
  X(rtcFilterOcclusion)                    \
  X(rtcSetGeometryInstancedScene)          \
  X(rtcSetGeometryTransform)               \
  X(rtcSetGeometryTransformQuaternion)     \
  X(rtcAttachGeometryByID)                 \
  X(rtcDetachGeometry)                     \
  X(rtcIntersect1)                         \
  X(rtcIntersect4)                         \
  X(rtcIntersect8)                         \
  X(rtcIntersect16)                        \
  X(rtcIntersect1M)                        \
  X(rtcIntersect1Mp)                       \
  X(rtcIntersectNM)                        \
  X(rtcIntersectNp)                        \
  X(rtcOccluded1)                          \
  X(rtcOccluded4)                          \
  X(rtcOccluded8)                          \
  X(rtcOccluded16)                         \
  X(rtcOccluded1M)                         \
  X(rtcOccluded1Mp)                        \
  X(rtcOccludedNM)                         \
  X(rtcOccludedNp)

/// One library's functions. It stays loaded until the process ends.
struct EmbreeApi {
#define DACRT_TESTS_MEMBER(name) decltype(&::name) name = nullptr;
  DACRT_TESTS_EMBREE_FUNCTIONS(DACRT_TESTS_MEMBER)
#undef DACRT_TESTS_MEMBER

  std::string path;
};

/// Opens the library at `path`, which must contain a slash: glibc takes a bare name for the SONAME
/// of a library that is already loaded, and both libraries have the same one.
/// Throws std::runtime_error if it cannot be opened, if it lacks a function, or if a function was
/// found in another file than `path`.
EmbreeApi LoadEmbree(const std::string& path);

}  // namespace dacrt::tests
