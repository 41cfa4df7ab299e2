// rtcore_buffer.h
#include <embree3/rtcore.h>

#include "boundary.h"
#include "buffer.h"
#include "device.h"

using namespace dacrt::compat;

RTC_API RTCBuffer rtcNewBuffer(RTCDevice hdevice, size_t byteSize) {
  return NewHandle<RTCBuffer>(__func__, hdevice, [&](Device& device) {
    return std::make_shared<Buffer>(device.shared_from_this(), byteSize);
  });
}

RTC_API RTCBuffer rtcNewSharedBuffer(RTCDevice hdevice, void* ptr, size_t byteSize) {
  return NewHandle<RTCBuffer>(__func__, hdevice, [&](Device& device) {
    return MakeBuffer(device.shared_from_this(), ptr, byteSize);
  });
}

RTC_API void* rtcGetBufferData(RTCBuffer hbuffer) {
  void* data = nullptr;
  OnObject(__func__, hbuffer, "buffer", [&](Buffer& buffer) { data = buffer.data(); });
  return data;
}

RTC_API void rtcRetainBuffer(RTCBuffer hbuffer) { RetainHandle(__func__, hbuffer, "buffer"); }

RTC_API void rtcReleaseBuffer(RTCBuffer hbuffer) { ReleaseHandle(__func__, hbuffer, "buffer"); }
