#include "boundary.h"

#include <new>
#include <utility>

#include "dacrt/error.h"
#include "device.h"

namespace dacrt::compat {
namespace {

thread_local RTCError thread_error = RTC_ERROR_NONE;

/// Embree's code and a message for the exception that is being handled.
std::pair<RTCError, std::string> TranslateCurrentException() {
  try {
    throw;
  } catch (const ApiError& error) {
    return {error.code(), error.what()};
  } catch (const std::bad_alloc&) {
    return {RTC_ERROR_OUT_OF_MEMORY, "out of memory"};
  } catch (const Error& error) {
    return {error.kind() == Error::Kind::kTooLarge ? RTC_ERROR_INVALID_OPERATION
                                                   : RTC_ERROR_INVALID_ARGUMENT,
            error.what()};
  } catch (const std::exception& error) {
    return {RTC_ERROR_UNKNOWN, error.what()};
  } catch (...) {
    return {RTC_ERROR_UNKNOWN, "unknown exception"};
  }
}

}  // namespace

void CheckPointer(const void* pointer, const char* name) {
  if (!pointer) throw ApiError(RTC_ERROR_INVALID_ARGUMENT, name, " is null");
}

void ReportCurrentException(const char* function, Device* device) {
  const auto [code, message] = TranslateCurrentException();
  if (device) {
    device->Report(code, std::string(function) + ": " + message);
  } else if (thread_error == RTC_ERROR_NONE) {
    thread_error = code;  // As in a device, the first error stays until it is read.
  }
}

RTCError TakeThreadError() { return std::exchange(thread_error, RTC_ERROR_NONE); }

}  // namespace dacrt::compat
