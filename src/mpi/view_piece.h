// Part of a batch, and single values of it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "dacrt/ray_view.h"

namespace dacrt::mpi {

/// What a hit writes into a ray's record.
struct HitRecord {
  float t;
  float ng[3];
  float u, v;
  uint32_t primitive_id, geometry_id, instance_id;
};
static_assert(sizeof(HitRecord) == 36);

/// The most rays, up to `count`, that Piece can begin at ray `first` of `view`: whole packets, or a
/// part of one.
inline std::size_t PieceLength(const RayView& view, std::size_t first, std::size_t count) {
  const std::size_t left = view.count - first;
  if (view.lanes == 1 || count >= left) count = std::min(count, left);
  const std::size_t in_packet = first % view.lanes;
  if (in_packet + count <= view.lanes) return count;
  if (in_packet > 0) return view.lanes - in_packet;
  return count == left ? count : count / view.lanes * view.lanes;
}

/// Rays first to first + count - 1 of `view`, where count is a PieceLength.
inline RayView Piece(const RayView& view, std::size_t first, std::size_t count) {
  RayView piece = view;
  piece.count = count;
  const std::size_t packet = first / view.lanes;
  std::size_t shift = first % view.lanes * view.lane_stride;
  if (view.packets) {
    piece.packets += packet;
  } else {
    shift += packet * view.packet_stride;
  }
  for (RayView::Component* const component :
       {&piece.org_x, &piece.org_y, &piece.org_z,        &piece.dir_x,       &piece.dir_y,
        &piece.dir_z, &piece.tnear, &piece.tfar,         &piece.mask,        &piece.time,
        &piece.id,    &piece.flags, &piece.ng_x,         &piece.ng_y,        &piece.ng_z,
        &piece.u,     &piece.v,     &piece.primitive_id, &piece.geometry_id, &piece.instance_id}) {
    if (*component != RayView::kAbsent) *component += shift;
  }
  return piece;
}

/// The value of a component of ray i, as its bits.
inline uint32_t ReadBits(const RayView& view, RayView::Component component, std::size_t i) {
  uint32_t bits;
  std::memcpy(&bits, reinterpret_cast<const void*>(view.Address(component, i)), sizeof(bits));
  return bits;
}

/// What Query::kClosest writes for a hit of ray i.
inline void WriteHit(RayView view, std::size_t i, const HitRecord& hit) {
  const std::uintptr_t start = view.Address(0, i);
  const auto write = [&](RayView::Component component, auto value) {
    static_assert(sizeof(value) == 4);
    if (component == RayView::kAbsent) return;
    std::memcpy(reinterpret_cast<void*>(start + component), &value, sizeof(value));
  };
  write(view.tfar, hit.t);
  write(view.ng_x, hit.ng[0]);
  write(view.ng_y, hit.ng[1]);
  write(view.ng_z, hit.ng[2]);
  write(view.u, hit.u);
  write(view.v, hit.v);
  write(view.primitive_id, hit.primitive_id);
  write(view.geometry_id, hit.geometry_id);
  write(view.instance_id, hit.instance_id);
}

/// What Query::kAny writes for a hit of ray i.
inline void WriteOccluded(const RayView& view, std::size_t i) {
  const float occluded = -std::numeric_limits<float>::infinity();
  std::memcpy(reinterpret_cast<void*>(view.Address(view.tfar, i)), &occluded, sizeof(occluded));
}

}  // namespace dacrt::mpi
