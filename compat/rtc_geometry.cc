// rtcore_geometry.h, as far as it is supported.
#include <embree3/rtcore.h>

#include "boundary.h"
#include "device.h"
#include "geometry.h"

using namespace dacrt::compat;

RTC_API RTCGeometry rtcNewGeometry(RTCDevice hdevice, RTCGeometryType type) {
  return NewHandle<RTCGeometry>(__func__, hdevice, [&](Device& device) {
    return std::make_shared<Geometry>(device.shared_from_this(), type);
  });
}

RTC_API void rtcRetainGeometry(RTCGeometry hgeometry) {
  RetainHandle(__func__, hgeometry, "geometry");
}

RTC_API void rtcReleaseGeometry(RTCGeometry hgeometry) {
  ReleaseHandle(__func__, hgeometry, "geometry");
}

RTC_API void rtcCommitGeometry(RTCGeometry hgeometry) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) { geometry.Commit(); });
}

RTC_API void rtcEnableGeometry(RTCGeometry hgeometry) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) { geometry.SetEnabled(true); });
}

RTC_API void rtcDisableGeometry(RTCGeometry hgeometry) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetEnabled(false); });
}

RTC_API void rtcSetGeometryTimeStepCount(RTCGeometry hgeometry, unsigned int timeStepCount) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetTimeStepCount(timeStepCount); });
}

RTC_API void rtcSetGeometryTimeRange(RTCGeometry hgeometry, float startTime, float endTime) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetTimeRange(startTime, endTime); });
}

RTC_API void rtcSetGeometryVertexAttributeCount(RTCGeometry hgeometry,
                                                unsigned int vertexAttributeCount) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetVertexAttributeCount(vertexAttributeCount); });
}

RTC_API void rtcSetGeometryMask(RTCGeometry hgeometry, unsigned int mask) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) { geometry.SetMask(mask); });
}

RTC_API void rtcSetGeometryBuildQuality(RTCGeometry hgeometry, RTCBuildQuality quality) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetBuildQuality(quality); });
}

RTC_API void rtcSetGeometryBuffer(RTCGeometry hgeometry, RTCBufferType type, unsigned int slot,
                                  RTCFormat format, RTCBuffer hbuffer, size_t byteOffset,
                                  size_t byteStride, size_t itemCount) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) {
    std::shared_ptr<Buffer> buffer = Resolve(hbuffer, "buffer");
    if (&buffer->device() != geometry.device().get()) {
      throw ApiError(RTC_ERROR_INVALID_ARGUMENT, "geometry and buffer are from different devices");
    }
    geometry.ChangeBuffers([&](GeometryBuffers& buffers) {
      buffers.Set(type, slot, format, {std::move(buffer), byteOffset, byteStride, itemCount});
    });
  });
}

RTC_API void rtcSetSharedGeometryBuffer(RTCGeometry hgeometry, RTCBufferType type,
                                        unsigned int slot, RTCFormat format, const void* ptr,
                                        size_t byteOffset, size_t byteStride, size_t itemCount) {
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) {
    geometry.ChangeBuffers([&](GeometryBuffers& buffers) {
      if (!ptr && byteOffset == 0) {  // Embree allocates then.
        buffers.SetNew(type, slot, format, byteStride, itemCount);
        return;
      }
      CheckPointer(ptr, "ptr");
      void* const data = const_cast<char*>(static_cast<const char*>(ptr)) + byteOffset;
      buffers.SetShared(type, slot, format, data, byteStride, itemCount);
    });
  });
}

RTC_API void* rtcSetNewGeometryBuffer(RTCGeometry hgeometry, RTCBufferType type, unsigned int slot,
                                      RTCFormat format, size_t byteStride, size_t itemCount) {
  void* data = nullptr;
  OnObject(__func__, hgeometry, "geometry", [&](Geometry& geometry) {
    geometry.ChangeBuffers([&](GeometryBuffers& buffers) {
      data = buffers.SetNew(type, slot, format, byteStride, itemCount);
    });
  });
  return data;
}

RTC_API void* rtcGetGeometryBufferData(RTCGeometry hgeometry, RTCBufferType type,
                                       unsigned int slot) {
  void* data = nullptr;
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { data = geometry.buffers().View(type, slot).data(); });
  return data;
}

RTC_API void rtcUpdateGeometryBuffer(RTCGeometry hgeometry, RTCBufferType type, unsigned int slot) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.UpdateBuffer(type, slot); });
}

RTC_API void rtcSetGeometryUserData(RTCGeometry hgeometry, void* ptr) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.set_user_data(ptr); });
}

// Programs call this once a hit, so the handle is trusted, as in a query.
RTC_API void* rtcGetGeometryUserData(RTCGeometry hgeometry) {
  void* data = nullptr;
  Guarded(__func__, nullptr, [&] {
    CheckPointer(hgeometry, "geometry");
    data = ToObject(hgeometry)->user_data();
  });
  return data;
}

// Filter functions

RTC_API void rtcSetGeometryIntersectFilterFunction(RTCGeometry hgeometry,
                                                   RTCFilterFunctionN filter) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetClosestFilter(filter); });
}

RTC_API void rtcSetGeometryOccludedFilterFunction(RTCGeometry hgeometry,
                                                  RTCFilterFunctionN filter) {
  OnObject(__func__, hgeometry, "geometry",
           [&](Geometry& geometry) { geometry.SetAnyFilter(filter); });
}
