// Bad calls, one by one: the drop-in reports the code that the real library reports, to the device
// or slot that the real one uses, with a message that names the function. What is specific to a
// type of geometry is in geometry_walk_test.cc.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "session.h"

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

std::vector<Case> Queries() {
  static RTCIntersectContext context;
  alignas(64) static RTCRayHit16 packet;
  alignas(64) static int valid[16];
  static RTCRayHit record;
  static RTCRayHitNp pointers;
  rtcInitIntersectContext(&context);
  record = RayAt(0.2f);
  const char* const intersect = "rtcIntersect1M";
  return {
      OnDevice("rtcIntersect1", "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcIntersect1(s.NewScene(), &context, &record); }),
      OnDevice("rtcIntersect16", "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcIntersect16(valid, s.NewScene(), &context, &packet); }),
      OnDevice(intersect, "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcIntersect1M(s.NewScene(), &context, &record, 1, 80); }),
      OnDevice("rtcOccluded1", "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcOccluded1(s.NewScene(), &context, &record.ray); }),
      OnDevice("rtcOccluded1M", "a scene that was not committed", kOperation,
               [](auto& s) { s.api.rtcOccluded1M(s.NewScene(), &context, &record.ray, 1, 80); }),
      OnDevice(
          intersect, "no rays at a null pointer", kNone,
          [](auto& s) { s.api.rtcIntersect1M(s.SceneOf(s.Triangle()), &context, nullptr, 0, 80); }),
      OnThread(
          intersect, "a null scene",
          [](auto& s) { s.api.rtcIntersect1M(nullptr, &context, &record, 1, 80); }, Real::kCrashes),
      OnThread(
          "rtcOccluded1", "a null scene",
          [](auto& s) { s.api.rtcOccluded1(nullptr, &context, &record.ray); }, Real::kCrashes),
      OnDevice(
          intersect, "a null context", kArgument,
          [](auto& s) { s.api.rtcIntersect1M(s.SceneOf(s.Triangle()), nullptr, &record, 1, 80); },
          Real::kCrashes),
      OnDevice(
          intersect, "a null ray", kArgument,
          [](auto& s) { s.api.rtcIntersect1M(s.SceneOf(s.Triangle()), &context, nullptr, 1, 80); },
          Real::kCrashes),
      OnDevice(
          "rtcIntersect16", "null valid flags", kArgument,
          [](auto& s) {
            s.api.rtcIntersect16(nullptr, s.SceneOf(s.Triangle()), &context, &packet);
          },
          Real::kCrashes),
      OnDevice(
          "rtcIntersectNp", "null origins", kArgument,
          [](auto& s) { s.api.rtcIntersectNp(s.SceneOf(s.Triangle()), &context, &pointers, 1); },
          Real::kCrashes),
  };
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
INSTANTIATE_TEST_SUITE_P(Devices, ErrorCodes, testing::ValuesIn(Devices()));
INSTANTIATE_TEST_SUITE_P(Buffers, ErrorCodes, testing::ValuesIn(Buffers()));
INSTANTIATE_TEST_SUITE_P(TypesAndQualities, ErrorCodes, testing::ValuesIn(TypesAndQualities()));
INSTANTIATE_TEST_SUITE_P(Scenes, ErrorCodes, testing::ValuesIn(Scenes()));
INSTANTIATE_TEST_SUITE_P(Queries, ErrorCodes, testing::ValuesIn(Queries()));

}  // namespace
}  // namespace dacrt::tests
