// Errors and properties of devices, on both libraries.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <thread>

#include "session.h"

namespace dacrt::tests {
namespace {

class Device : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Device);

void MakeArgumentError(Session& s) { s.api.rtcGetDeviceProperty(s.device, RTCDeviceProperty(999)); }
void MakeUnknownError(Session& s) { s.api.rtcNewGeometry(s.device, RTCGeometryType(999)); }

TEST_P(Device, ErrorIsNoneOnceItWasRead) {
  Session s(GetParam()());
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
  MakeArgumentError(s);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

TEST_P(Device, FirstErrorStaysUntilItIsRead) {
  Session s(GetParam()());
  MakeUnknownError(s);
  MakeArgumentError(s);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_UNKNOWN);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

TEST_P(Device, FirstErrorWithoutADeviceStaysUntilItIsRead) {
  const Api& api = GetParam()();
  EXPECT_EQ(api.rtcNewDevice("threads=abc"), nullptr);
  api.rtcReleaseScene(nullptr);
  EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_UNKNOWN);
  EXPECT_EQ(api.rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
}

TEST_P(Device, EachThreadHasItsOwnError) {
  Session s(GetParam()());
  MakeUnknownError(s);
  s.api.rtcReleaseScene(nullptr);
  std::thread([&] {
    EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
    EXPECT_EQ(s.api.rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
    MakeArgumentError(s);
  }).join();
  std::thread([&] { EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE); }).join();
  EXPECT_EQ(s.TakeError(), RTC_ERROR_UNKNOWN);
  EXPECT_EQ(s.api.rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
}

TEST_P(Device, DevicesDoNotShareErrors) {
  Session s(GetParam()());
  Session other(GetParam()());
  MakeUnknownError(s);
  EXPECT_EQ(other.TakeError(), RTC_ERROR_NONE);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_UNKNOWN);
}

TEST_P(Device, ErrorFunctionIsToldEveryError) {
  Session s(GetParam()());
  MakeUnknownError(s);
  MakeArgumentError(s);
  ASSERT_EQ(s.reports.size(), 2u);
  EXPECT_EQ(s.reports[0].code, RTC_ERROR_UNKNOWN);
  EXPECT_EQ(s.reports[1].code, RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_FALSE(s.reports[1].message.empty());

  s.api.rtcSetDeviceErrorFunction(s.device, nullptr, nullptr);
  MakeArgumentError(s);
  EXPECT_EQ(s.reports.size(), 2u);
}

// Programs turn errors into their own exceptions there.
TEST_P(Device, ErrorFunctionMayThrow) {
  Session s(GetParam()());
  s.api.rtcSetDeviceErrorFunction(
      s.device, [](void*, RTCError, const char* message) { throw std::runtime_error(message); },
      nullptr);
  EXPECT_THROW(MakeArgumentError(s), std::runtime_error);
}

TEST_P(Device, PropertiesThatBothHaveAreEqual) {
  Session s(GetParam()());
  const auto property = [&](RTCDeviceProperty p) {
    return s.api.rtcGetDeviceProperty(s.device, p);
  };
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_VERSION), 31305);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_VERSION_MAJOR), 3);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_VERSION_MINOR), 13);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_VERSION_PATCH), 5);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED), 1);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED), 1);
  if (GetParam() == &DropIn) {  // the real one has packets of 16 with AVX-512 only
    EXPECT_EQ(property(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED), 1);
  }
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_RAY_STREAM_SUPPORTED), 1);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_BACKFACE_CULLING_CURVES_ENABLED), 0);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED), 1);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED), 0);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_IGNORE_INVALID_RAYS_ENABLED), 0);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_COMPACT_POLYS_ENABLED), 0);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED), 1);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_TASKING_SYSTEM), 1);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_JOIN_COMMIT_SUPPORTED), 1);
  EXPECT_EQ(property(RTC_DEVICE_PROPERTY_PARALLEL_COMMIT_SUPPORTED), 1);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

}  // namespace
}  // namespace dacrt::tests
