#include "dacrt/version.h"

#define DACRT_TEXT(number) #number
#define DACRT_JOIN(major, minor, patch) \
  DACRT_TEXT(major) "." DACRT_TEXT(minor) "." DACRT_TEXT(patch)

namespace dacrt {

std::string_view Version() {
  return DACRT_JOIN(DACRT_VERSION_MAJOR, DACRT_VERSION_MINOR, DACRT_VERSION_PATCH);
}

}  // namespace dacrt
