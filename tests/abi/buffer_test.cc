// Buffers, on both libraries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "session.h"

namespace dacrt::tests {
namespace {

class Buffer : public OnBothLibraries {};
INSTANTIATE_ON_BOTH_LIBRARIES(Buffer);

TEST_P(Buffer, NewOneIsAligned) {
  Session s(GetParam()());
  const RTCBuffer buffer = s.NewBuffer(100);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(s.api.rtcGetBufferData(buffer)) % 16, 0u);
}

TEST_P(Buffer, SharedOneIsThePrograms) {
  Session s(GetParam()());
  float memory[4];
  const RTCBuffer buffer = s.Own(s.api.rtcNewSharedBuffer(s.device, memory, sizeof memory));
  EXPECT_EQ(s.api.rtcGetBufferData(buffer), memory);
}

TEST_P(Buffer, OfAGeometryIsWhereItWasPut) {
  Session s(GetParam()());
  const RTCGeometry geometry = s.NewGeometry();
  const auto data = [&](RTCBufferType type) {
    return s.api.rtcGetGeometryBufferData(geometry, type, 0);
  };
  const RTCBuffer buffer = s.NewBuffer(96);
  s.api.rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, buffer, 12, 24,
                             3);
  EXPECT_EQ(data(RTC_BUFFER_TYPE_VERTEX), static_cast<char*>(s.api.rtcGetBufferData(buffer)) + 12);

  unsigned int indices[8];
  s.api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices, 8,
                                   12, 2);
  EXPECT_EQ(data(RTC_BUFFER_TYPE_INDEX), indices + 2);

  void* const vertices =
      s.api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3);
  EXPECT_EQ(data(RTC_BUFFER_TYPE_VERTEX), vertices);

  float attributes[12];
  s.api.rtcSetGeometryVertexAttributeCount(geometry, 1);
  s.api.rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT4,
                                   attributes, 0, 16, 3);
  EXPECT_EQ(data(RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE), attributes);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_NONE);
}

TEST_P(Buffer, NewVerticesCanBeReadSixteenBytesAtATime) {
  Session s(GetParam()());
  auto* const vertices = static_cast<volatile float*>(s.api.rtcSetNewGeometryBuffer(
      s.NewGeometry(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3));
  // A sanitizer's build fails here if the padding is missing.
  vertices[9] = 1;
  EXPECT_EQ(vertices[9], 1);
}

TEST_P(Buffer, MemoryMonitorIsToldWhatIsAllocatedAndFreed) {
  using Log = std::vector<ssize_t>;
  Session s(GetParam()());
  Log log;
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device,
      [](void* user, ssize_t bytes, bool post) {
        EXPECT_EQ(post, bytes < 0);
        static_cast<Log*>(user)->push_back(bytes);
        return true;
      },
      &log);
  const RTCBuffer buffer = s.api.rtcNewBuffer(s.device, 100);
  s.api.rtcReleaseBuffer(buffer);
  const RTCGeometry geometry = s.api.rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  s.api.rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 10);
  s.api.rtcReleaseGeometry(geometry);
  EXPECT_EQ(log, (Log{100, -100, 124, -124}));
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
}

TEST(DropInBuffer, MemoryThatIsNotToBeHadIsGivenBackToTheMonitor) {
  Session s(DropIn());
  struct Sums {
    ssize_t held = 0, most = 0;
  } sums;
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device,
      [](void* user, ssize_t bytes, bool) {
        auto& sums = *static_cast<Sums*>(user);
        sums.held += bytes;
        sums.most = std::max(sums.most, sums.held);
        return true;
      },
      &sums);
  constexpr std::size_t kTooMuch = std::size_t{1} << 62;
  EXPECT_EQ(s.api.rtcNewBuffer(s.device, kTooMuch), nullptr);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_OUT_OF_MEMORY);
  EXPECT_EQ(sums.held, 0);
  EXPECT_EQ(sums.most, static_cast<ssize_t>(kTooMuch));
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
}

TEST_P(Buffer, MemoryMonitorCanRefuse) {
  Session s(GetParam()());
  s.api.rtcSetDeviceMemoryMonitorFunction(
      s.device, [](void*, ssize_t, bool) { return false; }, nullptr);
  EXPECT_EQ(s.api.rtcNewBuffer(s.device, 100), nullptr);
  EXPECT_EQ(s.TakeError(), RTC_ERROR_OUT_OF_MEMORY);
  s.api.rtcSetDeviceMemoryMonitorFunction(s.device, nullptr, nullptr);
}

}  // namespace
}  // namespace dacrt::tests
