// Calls in every form of a query.
#pragma once

#include <span>
#include <vector>

#include "api.h"
#include "streams.h"

namespace dacrt::tests {

/// Every way to call rtcIntersect* and rtcOccluded*.
std::vector<Form> AllForms();

inline bool IsStream(const Form& form) {
  return form.call != Form::Call::kRecord && form.call != Form::Call::kPacket;
}

/// Traces a copy of `rays`, as the function of streams.h does.
std::vector<RTCRayHit> Trace(const Api& api, RTCScene scene, RTCIntersectContext& context,
                             const Form& form, Query query, std::span<const RTCRayHit> rays);

}  // namespace dacrt::tests
