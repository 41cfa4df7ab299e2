// The calls that hand rays to a library with Embree's interface.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>
#include <span>
#include <string>

#include "embree_api.h"
#include "ray_buffer.h"

namespace dacrt::bench {

/// How a program hands over its rays, and whether it says that they are coherent.
struct Call {
  enum class Form { kSingleRays, kPackets4, kPackets8, kPackets16, kStream };

  Form form;
  bool is_coherent = false;

  bool operator==(const Call&) const = default;

  /// Rays of a packet; 1 where there are no packets.
  std::size_t PacketWidth() const;
};

inline constexpr Call kSingleRays{Call::Form::kSingleRays};
inline constexpr Call kIncoherentStream{Call::Form::kStream};
inline constexpr Call kCoherentStream{Call::Form::kStream, true};

/// As "coherent stream", "single rays" or "incoherent packets of 8".
std::string Name(const Call& call);

/// Brings the rays, a multiple of a packet, into the layout of packets of that width, where they
/// stand: a packet of Embree's is the transpose of as many records.
void MakePackets(std::size_t width, std::span<RayRecord> rays);

/// Undoes that.
void MakeRecords(std::size_t width, std::span<RayRecord> rays);

/// Traces the rays, which must be armed, and in packets where that is the form of the call. May be
/// called from several threads.
void Trace(const tests::EmbreeApi& api, RTCScene scene, Query query, const Call& call,
           std::span<RayRecord> rays);

}  // namespace dacrt::bench
