// Both libraries side by side: the real Embree and the drop-in, each behind a table of functions.
#pragma once

#include <embree3/rtcore.h>

#include <string>

/// Exported by Embree, in none of its headers.
extern "C" void rtcMakeStaticBVH(RTCBVH bvh);

namespace dacrt::tests {

/// One library's functions, all that compat/exports.txt names.
struct Api {
#define X(name) decltype(&::name) name = nullptr;
#include "exports.inc"
#undef X
  std::string name;  ///< "embree" or "dacrt"
};

/// The libraries, loaded once a process.
const Api& RealEmbree();
const Api& DropIn();

}  // namespace dacrt::tests
