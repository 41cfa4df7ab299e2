#include "streams.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "random.h"

namespace dacrt::tests {
namespace {

constexpr std::size_t kWordBytes = 4;
constexpr std::size_t kRayWords = sizeof(RTCRay) / kWordBytes;
constexpr std::size_t kRayHitWords = sizeof(RTCRayHit) / kWordBytes;
static_assert(kRayWords == 12 && kRayHitWords == 20);

/// Places of the components in a record, in words.
enum Word : std::size_t { kTnear = 3, kTime = 7, kTfar = 8, kMask = 9, kId = 10, kFlags = 11 };
enum HitWord : std::size_t { kNg = 12, kU = 15, kV = 16, kPrimId = 17, kGeomId = 18, kInstId = 19 };

/// Found in memory between records, which no call may change.
constexpr std::byte kGapPattern{0xa7};

/// Blocks of the alignment that the widest packets need.
struct alignas(64) Block {
  std::byte bytes[64];
};

/// Where word w of ray i stands in a form's memory. Packets of one lane are records, one packet of
/// all rays is a set of arrays.
struct Layout {
  std::size_t lanes;
  std::size_t word_stride;    ///< bytes from one component to the next
  std::size_t packet_stride;  ///< bytes from one packet to the next
  std::size_t packet_count;
  std::vector<uint32_t> packet_places;  ///< which place packet p has; empty: its own

  std::size_t PacketOffset(std::size_t packet) const {
    return (packet_places.empty() ? packet : packet_places[packet]) * packet_stride;
  }
};

Layout LayoutOf(const Form& form, std::size_t words, std::size_t ray_count) {
  Layout layout{};
  if (form.call == Form::Call::kArrays || form.call == Form::Call::kRequiredArrays) {
    layout.lanes = std::max<std::size_t>(ray_count, 1);
    // One word more, so that the arrays are aligned in all ways that are legal.
    layout.word_stride = (layout.lanes + 1) * kWordBytes;
    layout.packet_stride = words * layout.word_stride;
  } else {
    layout.lanes = form.lanes;
    layout.word_stride = form.lanes * kWordBytes;
    layout.packet_stride = words * layout.word_stride + form.gap;
  }
  layout.packet_count = (ray_count + layout.lanes - 1) / layout.lanes;
  if (form.call == Form::Call::kRecordPointers) {
    layout.packet_places.resize(layout.packet_count);
    std::iota(layout.packet_places.begin(), layout.packet_places.end(), 0);
    Random random(layout.packet_count);
    for (std::size_t i = layout.packet_count; i > 1; --i) {
      std::swap(layout.packet_places[i - 1],
                layout.packet_places[random.Below(static_cast<uint32_t>(i))]);
    }
  }
  return layout;
}

/// Calls `visit(address of word 0 in memory, record)` for each ray. Lanes past the last ray have no
/// record.
template <typename Records, typename Visit>
void ForEachRay(const Layout& layout, std::byte* memory, Records records, const Visit& visit) {
  for (std::size_t packet = 0, ray = 0; packet < layout.packet_count; ++packet) {
    std::byte* const start = memory + layout.PacketOffset(packet);
    const std::size_t end = std::min(ray + layout.lanes, records.size());
    for (std::size_t lane = 0; ray < end; ++ray, ++lane) {
      visit(start + lane * kWordBytes, records[ray]);
    }
  }
}

/// The first `words` words of records, packed as `layout` says.
class PackedRays {
 public:
  PackedRays(Layout layout, std::size_t words, std::span<const RTCRayHit> rays)
      : layout_(std::move(layout)),
        words_(words),
        blocks_(layout_.packet_count * layout_.packet_stride / sizeof(Block) + 1) {
    std::memset(memory(), static_cast<int>(kGapPattern), blocks_.size() * sizeof(Block));
    Pack(rays);
    SetInactive(rays.size());
  }

  std::byte* memory() { return blocks_.data()->bytes; }
  const Layout& layout() const { return layout_; }
  std::byte* Packet(std::size_t i) { return memory() + layout_.PacketOffset(i); }

  /// Address of component `word` of ray 0.
  template <typename T>
  T* Component(std::size_t word) {
    return reinterpret_cast<T*>(memory() + word * layout_.word_stride);
  }

  /// `rays` with the words that stand in memory.
  std::vector<RTCRayHit> Unpack(std::span<const RTCRayHit> rays) {
    std::vector<RTCRayHit> result(rays.begin(), rays.end());
    ForEachRay(layout_, memory(), std::span<RTCRayHit>(result),
               [this](const std::byte* word, RTCRayHit& record) {
                 std::byte* const words = reinterpret_cast<std::byte*>(&record);
                 for (std::size_t w = 0; w < words_; ++w) {
                   std::memcpy(words + w * kWordBytes, word + w * layout_.word_stride, kWordBytes);
                 }
               });
    return result;
  }

  bool operator==(const PackedRays& other) const {
    return blocks_.size() == other.blocks_.size() &&
           std::memcmp(blocks_.data(), other.blocks_.data(), blocks_.size() * sizeof(Block)) == 0;
  }

 private:
  void Pack(std::span<const RTCRayHit> rays) {
    ForEachRay(layout_, memory(), rays, [this](std::byte* word, const RTCRayHit& record) {
      const std::byte* const words = reinterpret_cast<const std::byte*>(&record);
      for (std::size_t w = 0; w < words_; ++w) {
        std::memcpy(word + w * layout_.word_stride, words + w * kWordBytes, kWordBytes);
      }
    });
  }

  /// Makes the lanes after the last ray inactive, as the caller of a stream of packets must.
  void SetInactive(std::size_t ray_count) {
    if (layout_.packet_count == 0) return;
    std::byte* const packet = Packet(layout_.packet_count - 1);
    for (std::size_t i = ray_count; i < layout_.packet_count * layout_.lanes; ++i) {
      const float tnear = 1, tfar = -1;
      std::byte* const word = packet + i % layout_.lanes * kWordBytes;
      std::memcpy(word + kTnear * layout_.word_stride, &tnear, kWordBytes);
      std::memcpy(word + kTfar * layout_.word_stride, &tfar, kWordBytes);
    }
  }

  Layout layout_;
  std::size_t words_;
  std::vector<Block> blocks_;
};

RTCRayNp RayArrays(PackedRays& rays, bool required_only) {
  const auto optional = [&]<typename T>(T* array) { return required_only ? nullptr : array; };
  return {.org_x = rays.Component<float>(0),
          .org_y = rays.Component<float>(1),
          .org_z = rays.Component<float>(2),
          .tnear = optional(rays.Component<float>(kTnear)),
          .dir_x = rays.Component<float>(4),
          .dir_y = rays.Component<float>(5),
          .dir_z = rays.Component<float>(6),
          .time = optional(rays.Component<float>(kTime)),
          .tfar = rays.Component<float>(kTfar),
          .mask = optional(rays.Component<unsigned>(kMask)),
          .id = optional(rays.Component<unsigned>(kId)),
          .flags = optional(rays.Component<unsigned>(kFlags))};
}

RTCHitNp HitArrays(PackedRays& rays, bool required_only) {
  const auto optional = [&]<typename T>(T* array) { return required_only ? nullptr : array; };
  return {.Ng_x = optional(rays.Component<float>(kNg)),
          .Ng_y = optional(rays.Component<float>(kNg + 1)),
          .Ng_z = optional(rays.Component<float>(kNg + 2)),
          .u = rays.Component<float>(kU),
          .v = rays.Component<float>(kV),
          .primID = rays.Component<unsigned>(kPrimId),
          .geomID = rays.Component<unsigned>(kGeomId),
          .instID = {optional(rays.Component<unsigned>(kInstId))}};
}

void TraceRecords(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context, Query query,
                  PackedRays& rays) {
  for (std::size_t i = 0; i < rays.layout().packet_count; ++i) {
    if (query == Query::kClosest) {
      api.rtcIntersect1(scene, &context, reinterpret_cast<RTCRayHit*>(rays.Packet(i)));
    } else {
      api.rtcOccluded1(scene, &context, reinterpret_cast<RTCRay*>(rays.Packet(i)));
    }
  }
}

template <uint32_t kLanes, typename Packet, typename Function>
void TracePackets(Function function, RTCScene scene, RTCIntersectContext& context,
                  std::size_t ray_count, PackedRays& rays) {
  for (std::size_t i = 0; i < rays.layout().packet_count; ++i) {
    alignas(64) int valid[kLanes];
    for (uint32_t lane = 0; lane < kLanes; ++lane)
      valid[lane] = i * kLanes + lane < ray_count ? -1 : 0;
    function(valid, scene, &context, reinterpret_cast<Packet*>(rays.Packet(i)));
  }
}

void TracePackets(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context, Query query,
                  std::size_t ray_count, PackedRays& rays) {
  const bool closest = query == Query::kClosest;
  switch (rays.layout().lanes) {
    case 4:
      return closest
                 ? TracePackets<4, RTCRayHit4>(api.rtcIntersect4, scene, context, ray_count, rays)
                 : TracePackets<4, RTCRay4>(api.rtcOccluded4, scene, context, ray_count, rays);
    case 8:
      return closest
                 ? TracePackets<8, RTCRayHit8>(api.rtcIntersect8, scene, context, ray_count, rays)
                 : TracePackets<8, RTCRay8>(api.rtcOccluded8, scene, context, ray_count, rays);
    case 16:
      return closest
                 ? TracePackets<16, RTCRayHit16>(api.rtcIntersect16, scene, context, ray_count,
                                                 rays)
                 : TracePackets<16, RTCRay16>(api.rtcOccluded16, scene, context, ray_count, rays);
    default:
      throw std::logic_error("packets have 4, 8 or 16 lanes");
  }
}

void TraceRecordStream(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context,
                       Query query, PackedRays& rays) {
  const auto count = static_cast<unsigned>(rays.layout().packet_count);
  const std::size_t stride = rays.layout().packet_stride;
  if (query == Query::kClosest) {
    api.rtcIntersect1M(scene, &context, rays.Component<RTCRayHit>(0), count, stride);
  } else {
    api.rtcOccluded1M(scene, &context, rays.Component<RTCRay>(0), count, stride);
  }
}

template <typename Record>
std::vector<Record*> Pointers(PackedRays& rays) {
  std::vector<Record*> pointers(rays.layout().packet_count);
  for (std::size_t i = 0; i < pointers.size(); ++i) {
    pointers[i] = reinterpret_cast<Record*>(rays.Packet(i));
  }
  return pointers;
}

void TracePointerStream(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context,
                        Query query, PackedRays& rays) {
  const auto count = static_cast<unsigned>(rays.layout().packet_count);
  if (query == Query::kClosest) {
    api.rtcIntersect1Mp(scene, &context, Pointers<RTCRayHit>(rays).data(), count);
  } else {
    api.rtcOccluded1Mp(scene, &context, Pointers<RTCRay>(rays).data(), count);
  }
}

void TracePacketStream(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context,
                       Query query, PackedRays& rays) {
  const auto lanes = static_cast<unsigned>(rays.layout().lanes);
  const auto count = static_cast<unsigned>(rays.layout().packet_count);
  const std::size_t stride = rays.layout().packet_stride;
  if (query == Query::kClosest) {
    api.rtcIntersectNM(scene, &context, rays.Component<RTCRayHitN>(0), lanes, count, stride);
  } else {
    api.rtcOccludedNM(scene, &context, rays.Component<RTCRayN>(0), lanes, count, stride);
  }
}

void TraceArrays(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context, Query query,
                 std::size_t ray_count, bool required_only, PackedRays& rays) {
  const auto count = static_cast<unsigned>(ray_count);
  if (query == Query::kClosest) {
    const RTCRayHitNp arrays{RayArrays(rays, required_only), HitArrays(rays, required_only)};
    api.rtcIntersectNp(scene, &context, &arrays, count);
  } else {
    const RTCRayNp arrays = RayArrays(rays, required_only);
    api.rtcOccludedNp(scene, &context, &arrays, count);
  }
}

}  // namespace

const char* Name(Query query) { return query == Query::kClosest ? "closest" : "any"; }

std::string Name(const Form& form) {
  std::ostringstream name;
  switch (form.call) {
    case Form::Call::kRecord:
      name << "1";
      break;
    case Form::Call::kPacket:
      name << form.lanes;
      break;
    case Form::Call::kRecords:
      name << "1M";
      break;
    case Form::Call::kRecordPointers:
      name << "1Mp";
      break;
    case Form::Call::kPackets:
      name << "NM_" << form.lanes;
      break;
    case Form::Call::kArrays:
      name << "Np";
      break;
    case Form::Call::kRequiredArrays:
      name << "Np_required";
      break;
  }
  if (form.gap) name << "_gap" << form.gap;
  if (form.coherent) name << "_coherent";
  return name.str();
}

std::vector<Form> StreamForms() {
  std::vector<Form> forms;
  for (const bool coherent : {false, true}) {
    // With records of 80 bytes: strides of 80, 96, 144 and 224.
    for (const uint32_t gap : {0u, 16u, 64u, 144u}) {
      forms.push_back({Form::Call::kRecords, coherent, 1, gap});
    }
    for (const uint32_t gap : {0u, 16u}) {
      forms.push_back({Form::Call::kRecordPointers, coherent, 1, gap});
    }
    for (const uint32_t lanes : {1u, 3u, 4u, 8u, 16u, 21u}) {
      forms.push_back({Form::Call::kPackets, coherent, lanes, 0});
    }
    forms.push_back({Form::Call::kPackets, coherent, 8, 64});
    forms.push_back({Form::Call::kArrays, coherent});
    forms.push_back({Form::Call::kRequiredArrays, coherent});
  }
  return forms;
}

std::vector<Form> PacketForms() {
  std::vector<Form> forms;
  for (const bool coherent : {false, true}) {
    forms.push_back({Form::Call::kRecord, coherent});
    for (const uint32_t lanes : {4u, 8u, 16u}) {
      forms.push_back({Form::Call::kPacket, coherent, lanes});
    }
  }
  return forms;
}

void ReplaceAbsent(const Form& form, std::span<RTCRayHit> rays) {
  if (form.call != Form::Call::kRequiredArrays) return;
  for (RTCRayHit& record : rays) {
    record.ray.tnear = 0;
    record.ray.time = 0;
    record.ray.mask = UINT32_MAX;
    record.ray.id = UINT32_MAX;
    record.ray.flags = UINT32_MAX;
  }
}

std::vector<RTCRayHit> Trace(const EmbreeApi& api, RTCScene scene, RTCIntersectContext& context,
                             const Form& form, Query query, std::span<const RTCRayHit> rays) {
  const std::size_t words = query == Query::kClosest ? kRayHitWords : kRayWords;
  PackedRays packed(LayoutOf(form, words, rays.size()), words, rays);

  context.flags =
      form.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  switch (form.call) {
    case Form::Call::kRecord:
      TraceRecords(api, scene, context, query, packed);
      break;
    case Form::Call::kPacket:
      TracePackets(api, scene, context, query, rays.size(), packed);
      break;
    case Form::Call::kRecords:
      TraceRecordStream(api, scene, context, query, packed);
      break;
    case Form::Call::kRecordPointers:
      TracePointerStream(api, scene, context, query, packed);
      break;
    case Form::Call::kPackets:
      TracePacketStream(api, scene, context, query, packed);
      break;
    case Form::Call::kArrays:
    case Form::Call::kRequiredArrays:
      TraceArrays(api, scene, context, query, rays.size(), form.call == Form::Call::kRequiredArrays,
                  packed);
      break;
  }

  std::vector<RTCRayHit> result = packed.Unpack(rays);
  // The records put where they came from must give the memory that the call left behind.
  if (PackedRays(packed.layout(), words, result) == packed) return result;
  throw std::runtime_error(api.path + " wrote outside of the records in a call of form " +
                           Name(form) + ", " + Name(query));
}

std::vector<RTCRayHit> Trace(const EmbreeScene& scene, const Form& form, Query query,
                             std::span<const RTCRayHit> rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return Trace(scene.api(), scene.handle(), context, form, query, rays);
}

}  // namespace dacrt::tests
