#include "boundary.h"

#include <cstdio>
#include <new>
#include <utility>

#include "dacrt/error.h"
#include "device.h"

namespace dacrt::compat {
namespace {

thread_local RTCError thread_error = RTC_ERROR_NONE;

/// Calls `report(code, message)` with Embree's code for the exception that is being handled.
template <class Report>
void TranslateCurrentException(const Report& report) {
  try {
    throw;
  } catch (const ApiError& error) {
    report(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    report(RTC_ERROR_OUT_OF_MEMORY, "out of memory");
  } catch (const Error& error) {
    report(error.kind() == Error::Kind::kTooLarge ? RTC_ERROR_INVALID_OPERATION
                                                  : RTC_ERROR_INVALID_ARGUMENT,
           error.what());
  } catch (const std::exception& error) {
    report(RTC_ERROR_UNKNOWN, error.what());
  } catch (...) {
    report(RTC_ERROR_UNKNOWN, "unknown exception");
  }
}

}  // namespace

void RefuseNull(const char* name) { throw ApiError(RTC_ERROR_INVALID_ARGUMENT, name, " is null"); }

void ReportCurrentException(const char* function, Device* device) {
  RTCError code;
  char text[1024];  // a longer message is cut off
  TranslateCurrentException([&](RTCError translated, const char* message) {
    code = translated;
    std::snprintf(text, sizeof(text), "%s: %s", function, message);
  });
  // Outside of the handlers: what the program's error function throws is no error of ours.
  if (device) {
    device->Report(code, text);
  } else if (thread_error == RTC_ERROR_NONE) {
    thread_error = code;  // As in a device, the first error stays until it is read.
  }
}

RTCError TakeThreadError() { return std::exchange(thread_error, RTC_ERROR_NONE); }

}  // namespace dacrt::compat
