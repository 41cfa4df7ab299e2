// The leaf test of user primitives: rays are handed to the program's intersect and occluded
// functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "trace/trace_task.h"

namespace dacrt {

/// The function that is asked about a primitive; there may be none.
inline const Callback& UserFunctionOf(Query query, const Geometry& user) {
  return query == Query::kClosest ? user.intersect : user.occluded;
}

/// Calls the function for some rays, at most CallOptions::callback_width of them, and takes over
/// what it says of them.
void CallUserFunction(Query query, const TraceTask& task, uint32_t geometry, uint32_t primitive,
                      std::span<const RayNumber> rays);

}  // namespace dacrt
