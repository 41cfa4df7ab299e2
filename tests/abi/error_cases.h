// Bad calls and what they report, a table of them for each part of the interface.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "model.h"

namespace dacrt::tests {

inline constexpr RTCError kNone = RTC_ERROR_NONE;
inline constexpr RTCError kUnknown = RTC_ERROR_UNKNOWN;
inline constexpr RTCError kArgument = RTC_ERROR_INVALID_ARGUMENT;
inline constexpr RTCError kOperation = RTC_ERROR_INVALID_OPERATION;
inline constexpr RTCError kMemory = RTC_ERROR_OUT_OF_MEMORY;

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

inline void PrintTo(const Case& test, std::ostream* out) {
  *out << test.function << ": " << test.what;
}

/// A call whose error goes to the device.
inline Case OnDevice(const char* function, std::string what, RTCError code,
                     std::function<void(Session&)> call, Real real = Real::kSame) {
  return {function, std::move(what), code, kNone, real, std::move(call)};
}

/// A call without a usable handle, whose error goes to the slot for no device.
inline Case OnThread(const char* function, std::string what, std::function<void(Session&)> call,
                     Real real = Real::kSame) {
  return {function, std::move(what), kNone, kArgument, real, std::move(call)};
}

/// The same where the real library crashes.
inline Case OnlyOurs(const char* function, std::string what, std::function<void(Session&)> call) {
  return OnThread(function, std::move(what), std::move(call), Real::kCrashes);
}

/// A null handle for every function that takes one.
std::vector<Case> NullHandles();

/// Functions of types of geometries that triangles are none of.
std::vector<Case> NullGeometries();

/// Most of these check nothing in the real library.
std::vector<Case> NullPointers();

/// The real library checks whether a scene is committed, and nothing else.
std::vector<Case> Queries();

}  // namespace dacrt::tests
