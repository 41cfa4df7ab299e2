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

template <class T>
void Write(const RayView& view, RayView::Component component, std::size_t i, T value) {
  static_assert(sizeof(T) == 4);
  if (component == RayView::kAbsent) return;
  std::memcpy(reinterpret_cast<void*>(view.Address(component, i)), &value, sizeof(value));
}

/// What Query::kClosest writes for a hit of ray i.
inline void WriteHit(const RayView& view, std::size_t i, const HitRecord& hit) {
  Write(view, view.tfar, i, hit.t);
  Write(view, view.ng_x, i, hit.ng[0]);
  Write(view, view.ng_y, i, hit.ng[1]);
  Write(view, view.ng_z, i, hit.ng[2]);
  Write(view, view.u, i, hit.u);
  Write(view, view.v, i, hit.v);
  Write(view, view.primitive_id, i, hit.primitive_id);
  Write(view, view.geometry_id, i, hit.geometry_id);
  Write(view, view.instance_id, i, hit.instance_id);
}

/// What Query::kAny writes for a hit of ray i.
inline void WriteOccluded(const RayView& view, std::size_t i) {
  Write(view, view.tfar, i, -std::numeric_limits<float>::infinity());
}

}  // namespace dacrt::mpi
