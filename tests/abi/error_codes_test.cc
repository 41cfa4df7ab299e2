// Bad calls, one by one: the drop-in reports the code that the real library reports, to the device
// or slot that the real one uses, with a message that names the function. What is specific to a
// type of geometry is in geometry_walk_test.cc.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "error_cases.h"

namespace dacrt::tests {
namespace {

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
