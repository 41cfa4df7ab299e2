// Bad calls, one by one: the drop-in reports the code that the real library reports, to the device
// or slot that the real one uses, with a message that names the function. What is specific to a
// type of geometry is in geometry_walk_test.cc.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <set>
#include <string>
#include <vector>

#include "model.h"

namespace dacrt::tests {
namespace {

constexpr RTCError kNone = RTC_ERROR_NONE;
constexpr RTCError kUnknown = RTC_ERROR_UNKNOWN;
constexpr RTCError kArgument = RTC_ERROR_INVALID_ARGUMENT;
constexpr RTCError kOperation = RTC_ERROR_INVALID_OPERATION;
constexpr RTCError kMemory = RTC_ERROR_OUT_OF_MEMORY;

/// What the real library does with a call.
enum class Real {
  kSame,     ///< reports the same
  kCrashes,  ///< is not asked
  kAccepts,  ///< reports nothing
};

struct Case {
  std::string function;  ///< that reports the error
  std::string what;
  RTCError device_error;  ///< of the drop-in
  RTCError thread_error;  ///< in the slot for no device
  Real real;
  std::function<void(Session&)> call;
};

void PrintTo(const Case& test, std::ostream* out) { *out << test.function << ": " << test.what; }

/// A call whose error goes to the device.
Case OnDevice(const char* function, std::string what, RTCError code,
              std::function<void(Session&)> call, Real real = Real::kSame) {
  return {function, std::move(what), code, kNone, real, std::move(call)};
}

/// A call without a usable handle, whose error goes to the slot for no device.
Case OnThread(const char* function, std::string what, std::function<void(Session&)> call,
              Real real = Real::kSame) {
  return {function, std::move(what), kNone, kArgument, real, std::move(call)};
}

/// The same where the real library crashes.
Case OnlyOurs(const char* function, std::string what, std::function<void(Session&)> call) {
  return OnThread(function, std::move(what), std::move(call), Real::kCrashes);
}

// A null handle for every function that takes one.
std::vector<Case> NullHandles() {
  static RTCBounds bounds;
  static RTCLinearBounds linear_bounds;
  static float floats[16];
  return {
      OnThread("rtcRetainDevice", "null", [](auto& s) { s.api.rtcRetainDevice(nullptr); }),
      OnThread("rtcReleaseDevice", "null", [](auto& s) { s.api.rtcReleaseDevice(nullptr); }),
      OnThread("rtcGetDeviceProperty", "null",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcGetDeviceProperty(nullptr, RTC_DEVICE_PROPERTY_VERSION), 0);
               }),
      OnThread(
          "rtcSetDeviceProperty", "null",
          [](auto& s) { s.api.rtcSetDeviceProperty(nullptr, RTC_DEVICE_PROPERTY_VERSION, 1); }),
      OnThread("rtcSetDeviceErrorFunction", "null",
               [](auto& s) { s.api.rtcSetDeviceErrorFunction(nullptr, nullptr, nullptr); }),
      OnThread(
          "rtcSetDeviceMemoryMonitorFunction", "null",
          [](auto& s) { s.api.rtcSetDeviceMemoryMonitorFunction(nullptr, nullptr, nullptr); },
          Real::kCrashes),
      OnThread("rtcNewBuffer", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewBuffer(nullptr, 16), nullptr); }),
      OnThread("rtcNewSharedBuffer", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewSharedBuffer(nullptr, floats, 16), nullptr); }),
      OnThread("rtcGetBufferData", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetBufferData(nullptr), nullptr); }),
      OnThread("rtcRetainBuffer", "null", [](auto& s) { s.api.rtcRetainBuffer(nullptr); }),
      OnThread("rtcReleaseBuffer", "null", [](auto& s) { s.api.rtcReleaseBuffer(nullptr); }),
      OnThread("rtcNewGeometry", "null device",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcNewGeometry(nullptr, RTC_GEOMETRY_TYPE_TRIANGLE), nullptr);
               }),
      OnThread("rtcRetainGeometry", "null", [](auto& s) { s.api.rtcRetainGeometry(nullptr); }),
      OnThread("rtcReleaseGeometry", "null", [](auto& s) { s.api.rtcReleaseGeometry(nullptr); }),
      OnThread("rtcCommitGeometry", "null", [](auto& s) { s.api.rtcCommitGeometry(nullptr); }),
      OnThread("rtcEnableGeometry", "null", [](auto& s) { s.api.rtcEnableGeometry(nullptr); }),
      OnThread("rtcDisableGeometry", "null", [](auto& s) { s.api.rtcDisableGeometry(nullptr); }),
      OnThread("rtcSetGeometryTimeStepCount", "null",
               [](auto& s) { s.api.rtcSetGeometryTimeStepCount(nullptr, 1); }),
      OnThread("rtcSetGeometryTimeRange", "null",
               [](auto& s) { s.api.rtcSetGeometryTimeRange(nullptr, 0, 1); }),
      OnThread("rtcSetGeometryVertexAttributeCount", "null",
               [](auto& s) { s.api.rtcSetGeometryVertexAttributeCount(nullptr, 1); }),
      OnThread("rtcSetGeometryMask", "null", [](auto& s) { s.api.rtcSetGeometryMask(nullptr, 1); }),
      OnThread("rtcSetGeometryBuildQuality", "null",
               [](auto& s) { s.api.rtcSetGeometryBuildQuality(nullptr, RTC_BUILD_QUALITY_LOW); }),
      OnThread("rtcSetGeometryMaxRadiusScale", "null",
               [](auto& s) { s.api.rtcSetGeometryMaxRadiusScale(nullptr, 1); }),
      OnThread("rtcSetGeometryBuffer", "null geometry",
               [](auto& s) {
                 s.api.rtcSetGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            s.NewBuffer(64), 0, 12, 4);
               }),
      OnThread("rtcSetSharedGeometryBuffer", "null geometry",
               [](auto& s) {
                 s.api.rtcSetSharedGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0,
                                                  RTC_FORMAT_FLOAT3, floats, 0, 12, 4);
               }),
      OnThread("rtcSetNewGeometryBuffer", "null geometry",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcSetNewGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0,
                                                         RTC_FORMAT_FLOAT3, 12, 4),
                           nullptr);
               }),
      OnThread("rtcGetGeometryBufferData", "null geometry",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcGetGeometryBufferData(nullptr, RTC_BUFFER_TYPE_VERTEX, 0),
                           nullptr);
               }),
      OnThread("rtcUpdateGeometryBuffer", "null geometry",
               [](auto& s) { s.api.rtcUpdateGeometryBuffer(nullptr, RTC_BUFFER_TYPE_VERTEX, 0); }),
      OnThread("rtcSetGeometryIntersectFilterFunction", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryIntersectFilterFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryOccludedFilterFunction", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryOccludedFilterFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryPointQueryFunction", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryPointQueryFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryUserData", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryUserData(nullptr, floats); }),
      OnThread("rtcGetGeometryUserData", "null geometry",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometryUserData(nullptr), nullptr); }),
      OnThread("rtcNewScene", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewScene(nullptr), nullptr); }),
      OnThread("rtcGetSceneDevice", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetSceneDevice(nullptr), nullptr); }),
      OnThread("rtcRetainScene", "null", [](auto& s) { s.api.rtcRetainScene(nullptr); }),
      OnThread("rtcReleaseScene", "null", [](auto& s) { s.api.rtcReleaseScene(nullptr); }),
      OnThread("rtcAttachGeometry", "null scene",
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcAttachGeometry(nullptr, s.Triangle()), RTC_INVALID_GEOMETRY_ID);
               }),
      OnThread("rtcAttachGeometryByID", "null scene",
               [](auto& s) { s.api.rtcAttachGeometryByID(nullptr, s.Triangle(), 0); }),
      OnThread("rtcDetachGeometry", "null scene",
               [](auto& s) { s.api.rtcDetachGeometry(nullptr, 0); }),
      OnThread(
          "rtcGetGeometry", "null scene",
          [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometry(nullptr, 0), nullptr); }, Real::kCrashes),
      OnThread(
          "rtcGetGeometryThreadSafe", "null scene",
          [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometryThreadSafe(nullptr, 0), nullptr); },
          Real::kCrashes),
      OnThread("rtcCommitScene", "null", [](auto& s) { s.api.rtcCommitScene(nullptr); }),
      OnThread("rtcJoinCommitScene", "null", [](auto& s) { s.api.rtcJoinCommitScene(nullptr); }),
      OnThread(
          "rtcSetSceneProgressMonitorFunction", "null",
          [](auto& s) { s.api.rtcSetSceneProgressMonitorFunction(nullptr, nullptr, nullptr); }),
      OnThread("rtcSetSceneBuildQuality", "null",
               [](auto& s) { s.api.rtcSetSceneBuildQuality(nullptr, RTC_BUILD_QUALITY_LOW); }),
      OnThread("rtcSetSceneFlags", "null",
               [](auto& s) { s.api.rtcSetSceneFlags(nullptr, RTC_SCENE_FLAG_NONE); }),
      OnThread("rtcGetSceneFlags", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcGetSceneFlags(nullptr), RTC_SCENE_FLAG_NONE); }),
      OnThread("rtcGetSceneBounds", "null",
               [](auto& s) { s.api.rtcGetSceneBounds(nullptr, &bounds); }),
      OnThread("rtcGetSceneLinearBounds", "null",
               [](auto& s) { s.api.rtcGetSceneLinearBounds(nullptr, &linear_bounds); }),
      OnDevice("rtcSetGeometryBuffer", "null buffer", kArgument,
               [](auto& s) {
                 s.api.rtcSetGeometryBuffer(s.Triangle(), RTC_BUFFER_TYPE_VERTEX, 0,
                                            RTC_FORMAT_FLOAT3, nullptr, 0, 12, 4);
               }),
      OnDevice("rtcAttachGeometry", "null geometry", kArgument,
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcAttachGeometry(s.NewScene(), nullptr), RTC_INVALID_GEOMETRY_ID);
               }),
      OnDevice("rtcAttachGeometryByID", "null geometry", kArgument,
               [](auto& s) { s.api.rtcAttachGeometryByID(s.NewScene(), nullptr, 0); }),
  };
}

/// Functions of types of geometries that triangles are none of.
std::vector<Case> NullGeometries() {
  static float matrix[16];
  static RTCQuaternionDecomposition quaternion;
  return {
      OnThread("rtcSetGeometryUserPrimitiveCount", "null",
               [](auto& s) { s.api.rtcSetGeometryUserPrimitiveCount(nullptr, 1); }),
      OnThread("rtcSetGeometryBoundsFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryBoundsFunction(nullptr, nullptr, nullptr); }),
      OnThread("rtcSetGeometryIntersectFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryIntersectFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryOccludedFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryOccludedFunction(nullptr, nullptr); }),
      OnThread("rtcSetGeometryInstancedScene", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryInstancedScene(nullptr, s.NewScene()); }),
      OnThread("rtcSetGeometryTransform", "null geometry",
               [](auto& s) {
                 s.api.rtcSetGeometryTransform(nullptr, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
               }),
      OnThread("rtcSetGeometryTransformQuaternion", "null geometry",
               [](auto& s) { s.api.rtcSetGeometryTransformQuaternion(nullptr, 0, &quaternion); }),
      OnlyOurs("rtcGetGeometryTransform", "null geometry",
               [](auto& s) {
                 s.api.rtcGetGeometryTransform(nullptr, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, matrix);
               }),
      OnDevice(
          "rtcGetGeometryTransform", "null matrix of an instance", kArgument,
          [](auto& s) {
            s.api.rtcGetGeometryTransform(Model(s, RTC_GEOMETRY_TYPE_INSTANCE), 0,
                                          RTC_FORMAT_FLOAT3X4_ROW_MAJOR, nullptr);
          },
          Real::kCrashes),
      OnThread("rtcSetGeometryTessellationRate", "null",
               [](auto& s) { s.api.rtcSetGeometryTessellationRate(nullptr, 1); }),
      OnThread("rtcSetGeometryTopologyCount", "null",
               [](auto& s) { s.api.rtcSetGeometryTopologyCount(nullptr, 1); }),
      OnThread("rtcSetGeometrySubdivisionMode", "null",
               [](auto& s) {
                 s.api.rtcSetGeometrySubdivisionMode(nullptr, 0, RTC_SUBDIVISION_MODE_PIN_ALL);
               }),
      OnThread("rtcSetGeometryVertexAttributeTopology", "null",
               [](auto& s) { s.api.rtcSetGeometryVertexAttributeTopology(nullptr, 0, 0); }),
      OnThread("rtcSetGeometryDisplacementFunction", "null",
               [](auto& s) { s.api.rtcSetGeometryDisplacementFunction(nullptr, nullptr); }),
      OnlyOurs("rtcGetGeometryFirstHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryFirstHalfEdge(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryFace", "null", [](auto& s) { s.api.rtcGetGeometryFace(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryNextHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryNextHalfEdge(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryPreviousHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryPreviousHalfEdge(nullptr, 0); }),
      OnlyOurs("rtcGetGeometryOppositeHalfEdge", "null",
               [](auto& s) { s.api.rtcGetGeometryOppositeHalfEdge(nullptr, 0, 0); }),
  };
}

/// Most of these check nothing in the real library.
std::vector<Case> NullPointers() {
  static RTCInterpolateArguments interpolate{};
  static RTCInterpolateNArguments interpolate_n{};
  static RTCIntersectFunctionNArguments intersect_args{};
  static RTCOccludedFunctionNArguments occluded_args{};
  return {
      OnlyOurs("rtcFilterIntersection", "null",
               [](auto& s) { s.api.rtcFilterIntersection(nullptr, nullptr); }),
      OnlyOurs("rtcFilterIntersection", "null filter arguments",
               [](auto& s) { s.api.rtcFilterIntersection(&intersect_args, nullptr); }),
      OnlyOurs("rtcFilterOcclusion", "null",
               [](auto& s) { s.api.rtcFilterOcclusion(nullptr, nullptr); }),
      OnlyOurs("rtcFilterOcclusion", "null filter arguments",
               [](auto& s) { s.api.rtcFilterOcclusion(&occluded_args, nullptr); }),
      OnlyOurs("rtcInterpolate", "null", [](auto& s) { s.api.rtcInterpolate(nullptr); }),
      OnlyOurs("rtcInterpolate", "null geometry",
               [](auto& s) { s.api.rtcInterpolate(&interpolate); }),
      OnlyOurs("rtcInterpolateN", "null", [](auto& s) { s.api.rtcInterpolateN(nullptr); }),
      OnlyOurs("rtcInterpolateN", "null geometry",
               [](auto& s) { s.api.rtcInterpolateN(&interpolate_n); }),
      OnlyOurs("rtcPointQuery", "null",
               [](auto& s) { s.api.rtcPointQuery(nullptr, nullptr, nullptr, nullptr, nullptr); }),
      OnlyOurs("rtcPointQuery4", "null",
               [](auto& s) {
                 s.api.rtcPointQuery4(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
               }),
      OnlyOurs("rtcPointQuery8", "null",
               [](auto& s) {
                 s.api.rtcPointQuery8(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
               }),
      OnlyOurs("rtcPointQuery16", "null",
               [](auto& s) {
                 s.api.rtcPointQuery16(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr);
               }),
      OnlyOurs("rtcCollide", "null",
               [](auto& s) { s.api.rtcCollide(nullptr, nullptr, nullptr, nullptr); }),
      OnThread("rtcNewBVH", "null device",
               [](auto& s) { EXPECT_EQ(s.api.rtcNewBVH(nullptr), nullptr); }),
      OnlyOurs("rtcBuildBVH", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcBuildBVH(nullptr), nullptr); }),
      OnlyOurs("rtcThreadLocalAlloc", "null",
               [](auto& s) { EXPECT_EQ(s.api.rtcThreadLocalAlloc(nullptr, 8, 8), nullptr); }),
      OnThread("rtcRetainBVH", "null", [](auto& s) { s.api.rtcRetainBVH(nullptr); }),
      OnThread("rtcReleaseBVH", "null", [](auto& s) { s.api.rtcReleaseBVH(nullptr); }),
      OnlyOurs("rtcMakeStaticBVH", "null", [](auto& s) { s.api.rtcMakeStaticBVH(nullptr); }),
  };
}

std::vector<Case> Devices() {
  return {
      OnDevice("rtcGetDeviceProperty", "unknown property", kArgument,
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcGetDeviceProperty(s.device, RTCDeviceProperty(999)), 0);
               }),
      OnDevice("rtcGetDeviceProperty", "a gap between the properties", kArgument,
               [](auto& s) {
                 EXPECT_EQ(s.api.rtcGetDeviceProperty(s.device, RTCDeviceProperty(36)), 0);
               }),
      OnDevice(
          "rtcSetDeviceProperty", "a property that is read only", kArgument,
          [](auto& s) { s.api.rtcSetDeviceProperty(s.device, RTC_DEVICE_PROPERTY_VERSION, 1); }),
      OnDevice("rtcSetDeviceProperty", "unknown property", kArgument,
               [](auto& s) { s.api.rtcSetDeviceProperty(s.device, RTCDeviceProperty(999), 1); }),
  };
}

std::vector<Case> Buffers() {
  static float floats[16];
  const auto set_vertices = [](std::size_t bytes, std::size_t offset, std::size_t stride,
                               std::size_t count) {
    return [=](Session& s) {
      s.api.rtcSetGeometryBuffer(s.NewGeometry(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                 s.NewBuffer(bytes), offset, stride, count);
    };
  };
  const char* const set = "rtcSetGeometryBuffer";
  return {
      OnDevice("rtcNewBuffer", "no bytes", kNone,
               [](auto& s) { EXPECT_EQ(s.api.rtcGetBufferData(s.NewBuffer(0)), nullptr); }),
      OnDevice("rtcNewBuffer", "2^60 bytes", kMemory,
               [](auto& s) { EXPECT_EQ(s.NewBuffer(std::size_t{1} << 60), nullptr); }),
      OnDevice("rtcNewSharedBuffer", "a null pointer allocates", kNone,
               [](auto& s) {
                 const RTCBuffer buffer = s.Own(s.api.rtcNewSharedBuffer(s.device, nullptr, 16));
                 EXPECT_NE(s.api.rtcGetBufferData(buffer), nullptr);
               }),
      OnDevice("rtcNewSharedBuffer", "no bytes", kNone,
               [](auto& s) {
                 const RTCBuffer buffer = s.Own(s.api.rtcNewSharedBuffer(s.device, floats, 0));
                 EXPECT_EQ(s.api.rtcGetBufferData(buffer), floats);
               }),
      OnDevice(set, "the whole buffer", kNone, set_vertices(48, 0, 12, 4)),
      OnDevice(set, "interleaved, up to the last byte", kNone, set_vertices(96, 12, 24, 4)),
      // Embree compares with the stride times the buffer's bytes, and reads beyond the end.
      OnDevice(set, "one item too many", kArgument, set_vertices(48, 0, 12, 5), Real::kAccepts),
      OnDevice(set, "an offset behind the end", kArgument, set_vertices(48, 480, 12, 4),
               Real::kAccepts),
      OnDevice(set, "far too many items", kArgument, set_vertices(48, 0, 12, 49)),
      OnDevice(set, "an offset far behind the end", kArgument, set_vertices(48, 4800, 12, 4)),
      OnDevice(set, "a buffer of another device", kArgument,
               [](auto& s) {
                 const RTCBuffer other = s.Own(s.api.rtcNewBuffer(s.OtherDevice(), 64));
                 s.api.rtcSetGeometryBuffer(s.NewGeometry(), RTC_BUFFER_TYPE_VERTEX, 0,
                                            RTC_FORMAT_FLOAT3, other, 0, 12, 4);
               }),
      OnDevice("rtcSetNewGeometryBuffer", "2^60 bytes", kMemory,
               [](auto& s) {
                 s.api.rtcSetNewGeometryBuffer(s.NewGeometry(), RTC_BUFFER_TYPE_VERTEX, 0,
                                               RTC_FORMAT_FLOAT3, std::size_t{1} << 40, 1 << 20);
               }),
      OnDevice("rtcSetSharedGeometryBuffer", "a null pointer allocates", kNone,
               [](auto& s) {
                 const RTCGeometry geometry = s.NewGeometry();
                 s.api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                  RTC_FORMAT_FLOAT3, nullptr, 0, 12, 4);
                 EXPECT_NE(s.api.rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0),
                           nullptr);
               }),
      OnDevice("rtcGetGeometryBufferData", "a buffer that was not set", kNone,
               [](auto& s) {
                 EXPECT_EQ(
                     s.api.rtcGetGeometryBufferData(s.NewGeometry(), RTC_BUFFER_TYPE_VERTEX, 0),
                     nullptr);
               }),
      OnDevice("rtcUpdateGeometryBuffer", "a buffer that was not set", kNone,
               [](auto& s) {
                 s.api.rtcUpdateGeometryBuffer(s.NewGeometry(), RTC_BUFFER_TYPE_VERTEX, 0);
               }),
  };
}

std::vector<Case> TypesAndQualities() {
  std::vector<Case> cases;
  for (const int quality : {-1, 0, 1, 2, 3, 4}) {
    cases.push_back(OnDevice("rtcSetSceneBuildQuality", std::to_string(quality),
                             quality < 0 || quality > 2 ? kUnknown : kNone, [=](Session& s) {
                               s.api.rtcSetSceneBuildQuality(s.NewScene(),
                                                             RTCBuildQuality(quality));
                             }));
  }
  for (const int type : {-1, 3, 7, 9, 14, 18, 23, 27, 35, 43, 53, 61, 119, 122, 999}) {
    cases.push_back(
        OnDevice("rtcNewGeometry", "type " + std::to_string(type), kUnknown, [=](Session& s) {
          EXPECT_EQ(s.api.rtcNewGeometry(s.device, RTCGeometryType(type)), nullptr);
        }));
  }
  return cases;
}

std::vector<Case> Scenes() {
  static RTCBounds bounds;
  static RTCLinearBounds linear_bounds;
  const char* const commit = "rtcCommitScene";
  return {
      OnDevice(
          "rtcAttachGeometryByID", "an ID that is taken", kOperation,
          [](auto& s) { s.api.rtcAttachGeometryByID(s.SceneOf(s.Triangle()), s.Triangle(), 0); }),
      OnDevice(
          "rtcAttachGeometryByID", "the invalid ID", kArgument,
          [](auto& s) {
            s.api.rtcAttachGeometryByID(s.NewScene(), s.Triangle(), RTC_INVALID_GEOMETRY_ID);
          },
          Real::kCrashes),
      OnDevice("rtcAttachGeometry", "a geometry of another device", kArgument,
               [](auto& s) {
                 const RTCGeometry other =
                     s.Own(s.api.rtcNewGeometry(s.OtherDevice(), RTC_GEOMETRY_TYPE_TRIANGLE));
                 EXPECT_EQ(s.api.rtcAttachGeometry(s.NewScene(), other), RTC_INVALID_GEOMETRY_ID);
               }),
      OnDevice("rtcAttachGeometryByID", "a geometry of another device", kArgument,
               [](auto& s) {
                 const RTCGeometry other =
                     s.Own(s.api.rtcNewGeometry(s.OtherDevice(), RTC_GEOMETRY_TYPE_TRIANGLE));
                 s.api.rtcAttachGeometryByID(s.NewScene(), other, 3);
               }),
      OnDevice("rtcDetachGeometry", "an ID of a scene without any", kOperation,
               [](auto& s) { s.api.rtcDetachGeometry(s.NewScene(), 0); }),
      OnDevice("rtcDetachGeometry", "an ID behind the last", kOperation,
               [](auto& s) { s.api.rtcDetachGeometry(s.SceneOf(s.Triangle()), 7); }),
      OnDevice("rtcDetachGeometry", "the invalid ID", kArgument,
               [](auto& s) {
                 s.api.rtcDetachGeometry(s.SceneOf(s.Triangle()), RTC_INVALID_GEOMETRY_ID);
               }),
      OnDevice("rtcDetachGeometry", "twice", kOperation,
               [](auto& s) {
                 const RTCScene scene = s.SceneOf(s.Triangle());
                 s.api.rtcDetachGeometry(scene, 0);
                 s.api.rtcDetachGeometry(scene, 0);
               }),
      OnDevice("rtcGetGeometry", "a detached ID", kNone,
               [](auto& s) {
                 const RTCScene scene = s.SceneOf(s.Triangle());
                 s.api.rtcDetachGeometry(scene, 0);
                 EXPECT_EQ(s.api.rtcGetGeometry(scene, 0), nullptr);
               }),
      OnDevice(
          "rtcGetGeometry", "an ID behind the last", kNone,
          [](auto& s) { EXPECT_EQ(s.api.rtcGetGeometry(s.SceneOf(s.Triangle()), 7), nullptr); },
          Real::kCrashes),
      OnDevice(
          "rtcGetGeometryThreadSafe", "an ID behind the last", kNone,
          [](auto& s) {
            EXPECT_EQ(s.api.rtcGetGeometryThreadSafe(s.SceneOf(s.Triangle()), 7), nullptr);
          },
          Real::kCrashes),
      OnDevice("rtcGetSceneBounds", "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcGetSceneBounds(s.NewScene(), &bounds); }),
      OnDevice("rtcGetSceneBounds", "null of a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcGetSceneBounds(s.NewScene(), nullptr); }),
      OnDevice("rtcGetSceneBounds", "after attaching", kOperation,
               [](auto& s) {
                 const RTCScene scene = s.SceneOf(s.Triangle());
                 s.api.rtcAttachGeometry(scene, s.Triangle());
                 s.api.rtcGetSceneBounds(scene, &bounds);
               }),
      OnDevice("rtcGetSceneBounds", "after attaching a disabled geometry", kNone,
               [](auto& s) {
                 const RTCScene scene = s.SceneOf(s.Triangle());
                 const RTCGeometry disabled = s.Triangle();
                 s.api.rtcDisableGeometry(disabled);
                 s.api.rtcAttachGeometry(scene, disabled);
                 s.api.rtcGetSceneBounds(scene, &bounds);
               }),
      OnDevice("rtcGetSceneBounds", "after detaching", kOperation,
               [](auto& s) {
                 const RTCScene scene = s.SceneOf(s.Triangle());
                 s.api.rtcDetachGeometry(scene, 0);
                 s.api.rtcGetSceneBounds(scene, &bounds);
               }),
      OnDevice(
          "rtcGetSceneBounds", "null", kOperation,
          [](auto& s) { s.api.rtcGetSceneBounds(s.SceneOf(s.Triangle()), nullptr); },
          Real::kCrashes),
      OnDevice("rtcSetSceneFlags", "flags that are none", kNone,
               [](auto& s) {
                 const RTCScene scene = s.SceneOf(s.Triangle());
                 s.api.rtcSetSceneFlags(scene, RTCSceneFlags(0x7FFFFFF0));
                 s.api.rtcCommitScene(scene);
                 EXPECT_EQ(s.HitGeometry(scene), 0u);
               }),
      OnDevice("rtcGetSceneLinearBounds", "null", kOperation,
               [](auto& s) { s.api.rtcGetSceneLinearBounds(s.SceneOf(s.Triangle()), nullptr); }),
      OnDevice("rtcGetSceneLinearBounds", "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcGetSceneLinearBounds(s.NewScene(), &linear_bounds); }),

      OnDevice(commit, "a new geometry that was not committed", kOperation,
               [](auto& s) { s.SceneOf(s.UncommittedTriangle()); }),
      OnDevice(commit, "a disabled geometry that was not committed", kNone,
               [](auto& s) {
                 const RTCGeometry geometry = s.UncommittedTriangle();
                 s.api.rtcDisableGeometry(geometry);
                 s.SceneOf(geometry);
               }),
      OnDevice(commit, "twice", kNone,
               [](auto& s) { s.api.rtcCommitScene(s.SceneOf(s.Triangle())); }),
      OnDevice("rtcJoinCommitScene", "a geometry that was not committed", kOperation,
               [](auto& s) {
                 const RTCScene scene = s.NewScene();
                 s.api.rtcAttachGeometry(scene, s.UncommittedTriangle());
                 s.api.rtcJoinCommitScene(scene);
               }),
  };
}

/// Pointers of which all go to `values`.
template <class Pointers>
Pointers PointersTo(void* values) {
  std::array<void*, sizeof(Pointers) / sizeof(void*)> all;
  all.fill(values);
  return std::bit_cast<Pointers>(all);
}

/// Calls a query function with these arguments, for one ray or packet at `rays`.
struct QueryFunction {
  const char* name;
  void (*call)(const Api&, const int* valid, RTCScene, RTCIntersectContext*, void* rays);
  bool is_packet = false;
};

const QueryFunction kQueryFunctions[] = {
    {"rtcIntersect1",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcIntersect1(scene, context, static_cast<RTCRayHit*>(rays));
     }},
    {"rtcIntersect4",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcIntersect4(valid, scene, context, static_cast<RTCRayHit4*>(rays));
     },
     true},
    {"rtcIntersect8",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcIntersect8(valid, scene, context, static_cast<RTCRayHit8*>(rays));
     },
     true},
    {"rtcIntersect16",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcIntersect16(valid, scene, context, static_cast<RTCRayHit16*>(rays));
     },
     true},
    {"rtcIntersect1M",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcIntersect1M(scene, context, static_cast<RTCRayHit*>(rays), 1, sizeof(RTCRayHit));
     }},
    {"rtcIntersect1Mp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       auto* pointer = static_cast<RTCRayHit*>(rays);
       api.rtcIntersect1Mp(scene, context, rays ? &pointer : nullptr, 1);
     }},
    {"rtcIntersectNM",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcIntersectNM(scene, context, static_cast<RTCRayHitN*>(rays), 1, 1, sizeof(RTCRayHit));
     }},
    {"rtcIntersectNp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       const auto pointers = PointersTo<RTCRayHitNp>(rays);
       api.rtcIntersectNp(scene, context, rays ? &pointers : nullptr, 1);
     }},
    {"rtcOccluded1",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcOccluded1(scene, context, static_cast<RTCRay*>(rays));
     }},
    {"rtcOccluded4",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcOccluded4(valid, scene, context, static_cast<RTCRay4*>(rays));
     },
     true},
    {"rtcOccluded8",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcOccluded8(valid, scene, context, static_cast<RTCRay8*>(rays));
     },
     true},
    {"rtcOccluded16",
     [](auto& api, auto valid, auto scene, auto context, void* rays) {
       api.rtcOccluded16(valid, scene, context, static_cast<RTCRay16*>(rays));
     },
     true},
    {"rtcOccluded1M",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcOccluded1M(scene, context, static_cast<RTCRay*>(rays), 1, sizeof(RTCRay));
     }},
    {"rtcOccluded1Mp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       auto* pointer = static_cast<RTCRay*>(rays);
       api.rtcOccluded1Mp(scene, context, rays ? &pointer : nullptr, 1);
     }},
    {"rtcOccludedNM",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       api.rtcOccludedNM(scene, context, static_cast<RTCRayN*>(rays), 1, 1, sizeof(RTCRay));
     }},
    {"rtcOccludedNp",
     [](auto& api, auto, auto scene, auto context, void* rays) {
       const auto pointers = PointersTo<RTCRayNp>(rays);
       api.rtcOccludedNp(scene, context, rays ? &pointers : nullptr, 1);
     }},
};

/// The real library checks whether a scene is committed, and nothing else.
std::vector<Case> Queries() {
  static RTCIntersectContext context;
  static RTCRayHit16 packet;
  alignas(64) static const int valid[16] = {-1};
  rtcInitIntersectContext(&context);
  std::vector<Case> cases;
  for (const QueryFunction& function : kQueryFunctions) {
    const char* const name = function.name;
    const auto call = function.call;
    cases.push_back(OnDevice(name, "a scene that was not committed", kOperation, [=](auto& s) {
      call(s.api, valid, s.NewScene(), &context, &packet);
    }));
    cases.push_back(OnlyOurs(name, "a null scene",
                             [=](auto& s) { call(s.api, valid, nullptr, &context, &packet); }));
    cases.push_back(OnDevice(
        name, "a null context", kArgument,
        [=](auto& s) { call(s.api, valid, s.SceneOf(s.Triangle()), nullptr, &packet); },
        Real::kCrashes));
    cases.push_back(OnDevice(
        name, "null rays", kArgument,
        [=](auto& s) { call(s.api, valid, s.SceneOf(s.Triangle()), &context, nullptr); },
        Real::kCrashes));
    if (!function.is_packet) continue;
    cases.push_back(OnDevice(
        name, "null valid flags", kArgument,
        [=](auto& s) { call(s.api, nullptr, s.SceneOf(s.Triangle()), &context, &packet); },
        Real::kCrashes));
  }
  cases.push_back(OnDevice(
      "rtcIntersectNp", "null origins", kArgument,
      [](auto& s) {
        const RTCRayHitNp pointers{};
        s.api.rtcIntersectNp(s.SceneOf(s.Triangle()), &context, &pointers, 1);
      },
      Real::kCrashes));
  cases.push_back(OnDevice(
      "rtcOccludedNp", "null origins", kArgument,
      [](auto& s) {
        const RTCRayNp pointers{};
        s.api.rtcOccludedNp(s.SceneOf(s.Triangle()), &context, &pointers, 1);
      },
      Real::kCrashes));
  cases.push_back(OnDevice("rtcIntersect1M", "no rays at a null pointer", kNone, [](auto& s) {
    s.api.rtcIntersect1M(s.SceneOf(s.Triangle()), &context, nullptr, 0, sizeof(RTCRayHit));
  }));
  return cases;
}

class ErrorCodes : public testing::TestWithParam<Case> {};

TEST_P(ErrorCodes, AreTheRealLibrarys) {
  const Case& test = GetParam();
  if (test.real != Real::kCrashes) {
    const bool accepts = test.real == Real::kAccepts;
    Session real(RealEmbree());
    test.call(real);
    EXPECT_EQ(real.TakeError(), accepts ? kNone : test.device_error) << "of the real library";
    EXPECT_EQ(real.api.rtcGetDeviceError(nullptr), accepts ? kNone : test.thread_error)
        << "of the real library";
  }

  Session ours(DropIn());
  test.call(ours);
  EXPECT_EQ(ours.TakeError(), test.device_error);
  EXPECT_EQ(ours.api.rtcGetDeviceError(nullptr), test.thread_error);
  ASSERT_EQ(ours.reports.size(), test.device_error == kNone ? 0u : 1u);
  for (const ErrorReport& report : ours.reports) {
    EXPECT_EQ(report.code, test.device_error);
    EXPECT_TRUE(report.message.starts_with(test.function + ": ")) << report.message;
  }
}

INSTANTIATE_TEST_SUITE_P(NullHandles, ErrorCodes, testing::ValuesIn(NullHandles()));
INSTANTIATE_TEST_SUITE_P(NullGeometries, ErrorCodes, testing::ValuesIn(NullGeometries()));
INSTANTIATE_TEST_SUITE_P(NullPointers, ErrorCodes, testing::ValuesIn(NullPointers()));
INSTANTIATE_TEST_SUITE_P(Devices, ErrorCodes, testing::ValuesIn(Devices()));
INSTANTIATE_TEST_SUITE_P(Buffers, ErrorCodes, testing::ValuesIn(Buffers()));
INSTANTIATE_TEST_SUITE_P(TypesAndQualities, ErrorCodes, testing::ValuesIn(TypesAndQualities()));
INSTANTIATE_TEST_SUITE_P(Scenes, ErrorCodes, testing::ValuesIn(Scenes()));
INSTANTIATE_TEST_SUITE_P(Queries, ErrorCodes, testing::ValuesIn(Queries()));

// So a new export cannot be forgotten. To these two a null pointer is an argument like others.
TEST(AllErrorCodes, HaveACaseForEveryExport) {
  std::set<std::string> asked = {"rtcNewDevice", "rtcGetDeviceError"};
  for (const auto& cases : {NullHandles(), NullGeometries(), NullPointers(), Queries()}) {
    for (const Case& test : cases) asked.insert(test.function);
  }
  std::set<std::string> exports;
#define X(name) exports.insert(#name);
#include "exports.inc"
#undef X
  EXPECT_EQ(asked, exports);
}

}  // namespace
}  // namespace dacrt::tests
