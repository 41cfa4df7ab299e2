// What stands between a C caller and this library: what is thrown inside becomes one of Embree's
// error codes outside, and no exception of ours leaves an API function.
#pragma once

#include <embree3/rtcore.h>

#include <exception>
#include <new>
#include <sstream>
#include <string>

#include "handles.h"

namespace dacrt::compat {

/// An error as the API reports it. The message names the argument and its value; the function's
/// name is put in front where the error is reported.
class ApiError : public std::exception {
 public:
  /// The message is `parts`, one after the other. Where there is no memory for it, the code counts.
  template <class... Parts>
  explicit ApiError(RTCError code, const Parts&... parts) : code_(code) {
    try {
      std::ostringstream text;
      (text << ... << parts);
      message_ = text.str();
    } catch (const std::bad_alloc&) {
    }
  }

  RTCError code() const { return code_; }
  const char* what() const noexcept override {
    return message_.empty() ? "no memory for a message" : message_.c_str();
  }

 private:
  RTCError code_;
  std::string message_;
};

[[noreturn, gnu::cold]] void RefuseNull(const char* name);

/// Throws RTC_ERROR_INVALID_ARGUMENT if `pointer`, the argument called `name`, is null.
inline void CheckPointer(const void* pointer, const char* name) {
  if (!pointer) [[unlikely]]
    RefuseNull(name);
}

/// Reports the exception that is being handled as an error of `function`: to `device`, or for a
/// null device into the calling thread's own slot. Allocates nothing: there may be no memory.
void ReportCurrentException(const char* function, Device* device);

/// The calling thread's error that belongs to no device. There is none afterwards.
RTCError TakeThreadError();

/// Runs `body`, the inside of the API function called `function`, and reports what it throws to
/// `device`, which may be null. Only what the program's own error callback throws gets out.
/// In line: around the shortest calls it would cost as much as they do.
template <class Body>
[[gnu::always_inline]] inline void Guarded(const char* function, Device* device, Body&& body) {
  try {
    body();
  } catch (...) {
    ReportCurrentException(function, device);
  }
}

/// The object behind `handle`, the argument called `name`. Throws RTC_ERROR_INVALID_ARGUMENT if the
/// handle is null, was released, or never was one.
template <class Handle>
auto Resolve(Handle handle, const char* name) {
  CheckPointer(handle, name);
  auto object = HandleTable<ObjectOf<Handle>>::Instance().Find(ToObject(handle));
  if (!object) {
    throw ApiError(RTC_ERROR_INVALID_ARGUMENT, name, " = ", static_cast<const void*>(handle),
                   " is released or was never a handle");
  }
  return object;
}

/// Runs `body` on the object behind `handle`, as Guarded does, and keeps the object alive
/// meanwhile.
template <class Handle, class Body>
void OnObject(const char* function, Handle handle, const char* name, Body&& body) {
  std::shared_ptr<ObjectOf<Handle>> object;
  Guarded(function, nullptr, [&] { object = Resolve(handle, name); });
  if (object) Guarded(function, &DeviceOf(*object), [&] { body(*object); });
}

/// A handle of the object that `make` makes from the device behind `hdevice`; null if it fails.
template <class Handle, class Make>
Handle NewHandle(const char* function, RTCDevice hdevice, Make&& make) {
  Handle handle = nullptr;
  OnObject(function, hdevice, "device", [&](Device& device) {
    handle = ToHandle(HandleTable<ObjectOf<Handle>>::Instance().Add(make(device)));
  });
  return handle;
}

/// One more reference of the program to the object behind `handle`.
template <class Handle>
void RetainHandle(const char* function, Handle handle, const char* name) {
  OnObject(function, handle, name, [](auto& object) {
    HandleTable<ObjectOf<Handle>>::Instance().Retain(object.shared_from_this());
  });
}

/// One reference less. The last one may end the object.
template <class Handle>
void ReleaseHandle(const char* function, Handle handle, const char* name) {
  OnObject(function, handle, name, [&](auto& object) {
    if (!HandleTable<ObjectOf<Handle>>::Instance().Release(&object)) {
      throw ApiError(RTC_ERROR_INVALID_ARGUMENT, name, " = ", static_cast<const void*>(handle),
                     " was released as often as it was retained");
    }
  });
}

}  // namespace dacrt::compat
