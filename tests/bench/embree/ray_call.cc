#include "ray_call.h"

#include <cstdint>
#include <cstring>

namespace dacrt::bench {
namespace {

// A RayRecord is handed over as what it is a copy of.
static_assert(sizeof(RayRecord) == sizeof(RTCRayHit));
static_assert(alignof(RayRecord) == alignof(RTCRayHit));
static_assert(offsetof(RayRecord, tfar) == offsetof(RTCRayHit, ray.tfar));
static_assert(offsetof(RayRecord, id) == offsetof(RTCRayHit, ray.id));
static_assert(offsetof(RayRecord, ng) == offsetof(RTCRayHit, hit.Ng_x));
static_assert(offsetof(RayRecord, geometry_id) == offsetof(RTCRayHit, hit.geomID));
static_assert(offsetof(RayRecord, instance_id) == offsetof(RTCRayHit, hit.instID));

// A packet of W rays is W words of each member of a record, in the same order.
constexpr std::size_t kWords = sizeof(RayRecord) / sizeof(uint32_t);
constexpr std::size_t kMostWidth = 16;
static_assert(sizeof(RTCRayHit4) == 4 * sizeof(RayRecord));
static_assert(sizeof(RTCRayHit8) == 8 * sizeof(RayRecord));
static_assert(sizeof(RTCRayHit16) == 16 * sizeof(RayRecord));
static_assert(offsetof(RTCRayHit16, ray.tfar) == 16 * offsetof(RayRecord, tfar));
static_assert(offsetof(RTCRayHit16, hit.Ng_x) == 16 * offsetof(RayRecord, ng));
static_assert(offsetof(RTCRayHit16, hit.instID) == 16 * offsetof(RayRecord, instance_id));
static_assert(alignof(RTCRayHit16) <= RayBuffer::kAlignment);

// Each run of rows x columns words becomes columns x rows.
void Transpose(std::size_t rows, std::size_t columns, std::span<RayRecord> rays) {
  uint32_t old[kMostWidth * kWords];
  const std::size_t width = rows * columns / kWords;
  for (std::size_t first = 0; first < rays.size(); first += width) {
    std::memcpy(old, &rays[first], rows * columns * sizeof(uint32_t));
    const auto words = reinterpret_cast<uint32_t*>(&rays[first]);
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t column = 0; column < columns; ++column) {
        std::memcpy(words + column * rows + row, old + row * columns + column, sizeof(uint32_t));
      }
    }
  }
}

template <class Packet, class TracePacket>
void ForEachPacket(std::span<RayRecord> rays, const TracePacket& trace) {
  const auto packets = reinterpret_cast<Packet*>(rays.data());
  const std::size_t count = rays.size() / (sizeof(Packet) / sizeof(RayRecord));
  for (std::size_t i = 0; i < count; ++i) trace(packets[i]);
}

}  // namespace

std::size_t Call::PacketWidth() const {
  switch (form) {
    case Form::kPackets4:
      return 4;
    case Form::kPackets8:
      return 8;
    case Form::kPackets16:
      return 16;
    case Form::kSingleRays:
    case Form::kStream:
      break;
  }
  return 1;
}

std::string Name(const Call& call) {
  if (call.form == Call::Form::kSingleRays) return "single rays";
  const std::string coherence = call.is_coherent ? "coherent " : "incoherent ";
  if (call.form == Call::Form::kStream) return coherence + "stream";
  return coherence + "packets of " + std::to_string(call.PacketWidth());
}

void MakePackets(std::size_t width, std::span<RayRecord> rays) { Transpose(width, kWords, rays); }

void MakeRecords(std::size_t width, std::span<RayRecord> rays) { Transpose(kWords, width, rays); }

void Trace(const tests::EmbreeApi& api, RTCScene scene, Query query, const Call& call,
           std::span<RayRecord> rays) {
  alignas(64) static constexpr int kAllValid[kMostWidth] = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                            -1, -1, -1, -1, -1, -1, -1, -1};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (call.is_coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  const bool is_any = query == Query::kAny;
  const auto first = reinterpret_cast<RTCRayHit*>(rays.data());
  const auto count = static_cast<unsigned>(rays.size());

  switch (call.form) {
    case Call::Form::kSingleRays:
      if (is_any) {
        for (unsigned i = 0; i < count; ++i) api.rtcOccluded1(scene, &context, &first[i].ray);
      } else {
        for (unsigned i = 0; i < count; ++i) api.rtcIntersect1(scene, &context, &first[i]);
      }
      break;
    case Call::Form::kPackets4:
      ForEachPacket<RTCRayHit4>(rays, [&](RTCRayHit4& packet) {
        is_any ? api.rtcOccluded4(kAllValid, scene, &context, &packet.ray)
               : api.rtcIntersect4(kAllValid, scene, &context, &packet);
      });
      break;
    case Call::Form::kPackets8:
      ForEachPacket<RTCRayHit8>(rays, [&](RTCRayHit8& packet) {
        is_any ? api.rtcOccluded8(kAllValid, scene, &context, &packet.ray)
               : api.rtcIntersect8(kAllValid, scene, &context, &packet);
      });
      break;
    case Call::Form::kPackets16:
      ForEachPacket<RTCRayHit16>(rays, [&](RTCRayHit16& packet) {
        is_any ? api.rtcOccluded16(kAllValid, scene, &context, &packet.ray)
               : api.rtcIntersect16(kAllValid, scene, &context, &packet);
      });
      break;
    case Call::Form::kStream:
      if (is_any) {
        api.rtcOccluded1M(scene, &context, &first->ray, count, sizeof(RTCRayHit));
      } else {
        api.rtcIntersect1M(scene, &context, first, count, sizeof(RTCRayHit));
      }
      break;
  }
}

}  // namespace dacrt::bench
