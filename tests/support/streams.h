// The forms in which Embree takes rays. A test is written once, over records of RTCRayHit, and run
// through every form: packed into the form's memory, traced, and unpacked again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "embree_scene.h"

namespace dacrt::tests {

enum class Query { kClosest, kAny };

const char* Name(Query query);

/// One way of calling rtcIntersect* or rtcOccluded*.
struct Form {
  enum class Call {
    kRecord,          ///< rtcIntersect1, a call for each ray
    kPacket,          ///< rtcIntersect4, 8 or 16, a call for `lanes` rays
    kRecords,         ///< rtcIntersect1M
    kRecordPointers,  ///< rtcIntersect1Mp, the records in shuffled places
    kPackets,         ///< rtcIntersectNM
    kArrays,          ///< rtcIntersectNp, an array for each component
    kRequiredArrays,  ///< rtcIntersectNp, null for each component that may be absent
  };
  Call call;
  bool coherent = false;  ///< what the context says of the rays
  uint32_t lanes = 1;     ///< of kPacket and kPackets
  uint32_t gap = 0;       ///< bytes between records or packets
};

/// Whether it takes any number of rays in one call.
inline bool IsStream(const Form& form) {
  return form.call != Form::Call::kRecord && form.call != Form::Call::kPacket;
}

/// What to call `form` in reports and test names: letters, digits and underscores.
std::string Name(const Form& form);

/// The forms that take any number of rays in one call.
std::vector<Form> StreamForms();

/// The forms that take 1, 4, 8 or 16 rays a call.
std::vector<Form> PacketForms();

/// Gives components that `form` cannot carry the values that a library uses in their place, so that
/// a record says what is traced.
void ReplaceAbsent(const Form& form, std::span<RTCRayHit> rays);

/// Traces a copy of `rays` and returns the records afterwards, hits in place. The flags of
/// `context` are those of the form. Throws std::runtime_error if a byte changed that belongs to no
/// record.
std::vector<RTCRayHit> Trace(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context,
                             const Form& form, Query query, std::span<const RTCRayHit> rays);

/// The same with a context that says nothing else.
std::vector<RTCRayHit> Trace(const EmbreeScene& scene, const Form& form, Query query,
                             std::span<const RTCRayHit> rays);

}  // namespace dacrt::tests
