// Embree's forms of a batch of rays as the engine's view of one.
#pragma once

#include <embree3/rtcore.h>

#include <cstddef>

#include "dacrt/ray_view.h"

namespace dacrt::compat {

/// What a record holds: a ray alone (occlusion), or a ray with a hit behind it.
enum class Record { kRay, kRayHit };

/// NM: `packet_count` packets of `lanes` rays each, in SoA layout, `packet_stride` bytes apart.
/// 1M is the same with one lane, and so is a single ray.
RayView PacketView(void* packets, std::size_t lanes, std::size_t packet_count,
                   std::size_t packet_stride, Record record);

/// 1Mp: `count` pointers to records.
RayView PointerView(const void* const* records, std::size_t count, Record record);

/// Np: a pointer for each component to `count` values. Null pointers mean what RayView::kAbsent
/// means, whose defaults are Embree's.
RayView ComponentView(const RTCRayNp& rays, std::size_t count);
RayView ComponentView(const RTCRayHitNp& rays, std::size_t count);

}  // namespace dacrt::compat
