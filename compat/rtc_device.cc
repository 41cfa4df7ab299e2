// rtcore_device.h
#include <embree3/rtcore.h>

#include <cstdio>
#include <exception>

#include "boundary.h"
#include "device.h"

using namespace dacrt::compat;

RTC_API RTCDevice rtcNewDevice(const char* config) {
  RTCDevice device = nullptr;
  Guarded(__func__, nullptr, [&] {
    try {
      device = ToHandle(
          HandleTable<Device>::Instance().Add(std::make_shared<Device>(ReadConfig(config))));
    } catch (const std::exception& error) {
      // Without a device there is no error function yet that the message could go to.
      std::fprintf(stderr, "rtcNewDevice: %s\n", error.what());
      throw;
    }
  });
  return device;
}

RTC_API void rtcRetainDevice(RTCDevice hdevice) { RetainHandle(__func__, hdevice, "device"); }

RTC_API void rtcReleaseDevice(RTCDevice hdevice) { ReleaseHandle(__func__, hdevice, "device"); }

RTC_API ssize_t rtcGetDeviceProperty(RTCDevice hdevice, RTCDeviceProperty prop) {
  ssize_t value = 0;
  OnObject(__func__, hdevice, "device", [&](Device& device) { value = device.Property(prop); });
  return value;
}

RTC_API void rtcSetDeviceProperty(RTCDevice hdevice, const RTCDeviceProperty prop, ssize_t) {
  OnObject(__func__, hdevice, "device", [&](Device&) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "prop = ", static_cast<int>(prop),
                   " is no writable property");
  });
}

RTC_API RTCError rtcGetDeviceError(RTCDevice hdevice) {
  if (!hdevice) return TakeThreadError();
  RTCError error = RTC_ERROR_NONE;
  OnObject(__func__, hdevice, "device", [&](Device& device) { error = device.TakeError(); });
  return error;
}

RTC_API void rtcSetDeviceErrorFunction(RTCDevice hdevice, RTCErrorFunction error, void* userPtr) {
  OnObject(__func__, hdevice, "device",
           [&](Device& device) { device.SetErrorFunction(error, userPtr); });
}

RTC_API void rtcSetDeviceMemoryMonitorFunction(RTCDevice hdevice,
                                               RTCMemoryMonitorFunction memoryMonitor,
                                               void* userPtr) {
  OnObject(__func__, hdevice, "device",
           [&](Device& device) { device.SetMemoryMonitorFunction(memoryMonitor, userPtr); });
}
