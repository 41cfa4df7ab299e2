// How the library reports errors.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "dacrt/export.h"

namespace dacrt {

/// What the functions of this library throw: one type, with the function, the argument and its
/// value as parts, for programs that report errors in their own words.
///
/// Why exceptions, and not codes: a constructor gives a device or a scene that works, or none; and
/// a code that nobody checks would be a picture with holes. A std::invalid_argument, so that a
/// program that has never heard of this type reports the error just as well. Programs that cannot
/// use exceptions have the drop-in, a C interface with error codes.
///
/// Nothing has changed where it is thrown: no object was made, no ray written. Besides it there are
/// std::bad_alloc, where there is no memory, and for several processes mpi::Fault.
class DACRT_API Error : public std::invalid_argument {
 public:
  enum class Kind {
    kArgument,  ///< an argument that is never legal
    kTooLarge,  ///< more of something than the engine can number
  };

  /// `reason` says what is wrong, or what is legal.
  Error(Kind kind, const std::string& function, const std::string& argument,
        const std::string& value, const std::string& reason)
      : std::invalid_argument(function + ": " + argument + " = " + value + ": " + reason),
        kind_(kind),
        function_(function),
        argument_(argument),
        value_(value) {}

  Kind kind() const { return kind_; }
  const std::string& function() const { return function_; }  ///< e.g. "Scene" or "Trace"
  const std::string& argument() const { return argument_; }  ///< e.g. "geometry 3: vertices"
  const std::string& value() const { return value_; }  ///< as a message has it: texts in quotes

  // what() holds them all, and the reason: "Scene: geometry 3: vertices = null: there are 8".

 private:
  Kind kind_;
  std::string function_, argument_, value_;
};

}  // namespace dacrt
