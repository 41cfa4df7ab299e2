// How a batch of rays lies in the caller's memory.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace dacrt {

/// Where the components of a batch of rays stand. One description serves arrays of records,
/// structures of arrays, packets of any width and tables of pointers:
///
///   ray i is lane i % lanes of packet i / lanes; its component c stands at
///     packet_address(i / lanes) + c + (i % lanes) * lane_stride
///   where packet_address(p) is packets[p] if `packets` is set, else p * packet_stride.
///
/// So without a table a component is the absolute address of ray 0's value, with a table it is an
/// offset from the packet's start. `kAbsent` marks a component that the caller does not have:
/// reading it gives the default named below, writing it does nothing.
///
/// Every value has four bytes, in the machine's byte order, naturally aligned.
///
/// A ray is the segment org + t * dir, tnear < t <= tfar. dir need not be normalised; t is in units
/// of dir. A ray is inactive, and not one byte of it changes, if tnear > tfar, if tfar is negative,
/// if a component of org or dir is not finite, or if tnear or tfar is not a number. A negative
/// tnear counts as zero for the volumes that the ray enters.
///
/// A miss leaves every byte as it was. What a hit writes depends on the query:
///   Query::kClosest  tfar, ng (unnormalised, e2 x e1 with e1 = v0 - v1, e2 = v2 - v0), u, v,
///                    primitive_id, geometry_id, and into instance_id the instance's geometry_id
///                    or, outside of instances, `instance_value`. In an instance ng is in the
///                    space of the instanced scene. Quads and grids have u, v and ng of their own
///                    (see Shape), spheres and discs u = v = 0 and the outward normal, unnormalised
///   Query::kAny      tfar = -infinity, nothing else
/// All of a call's reads of a record come before its first write to that record.
struct RayView {
  using Component = std::uintptr_t;
  static constexpr Component kAbsent = UINTPTR_MAX;

  std::size_t count = 0;                 ///< number of rays
  std::size_t lanes = 1;                 ///< rays in a packet, at least 1
  std::size_t lane_stride = 0;           ///< bytes from one lane to the next
  std::size_t packet_stride = 0;         ///< bytes from one packet to the next; unused with a table
  const void* const* packets = nullptr;  ///< a pointer for each packet, or null

  // Read. org and dir and tfar must be present.
  Component org_x = kAbsent, org_y = kAbsent, org_z = kAbsent;
  Component dir_x = kAbsent, dir_y = kAbsent, dir_z = kAbsent;
  Component tnear = kAbsent;  ///< default 0
  Component tfar = kAbsent;   ///< also written
  Component mask = kAbsent;   ///< default all bits; see TriangleMesh::mask
  Component time = kAbsent;   ///< default 0; of moving geometries, and handed to callbacks
  Component id = kAbsent;     ///< default 0xFFFFFFFF; handed to callbacks
  Component flags = kAbsent;  ///< default 0xFFFFFFFF; handed to callbacks

  // Written by closest-hit queries.
  Component ng_x = kAbsent, ng_y = kAbsent, ng_z = kAbsent;
  Component u = kAbsent, v = kAbsent;
  Component primitive_id = kAbsent, geometry_id = kAbsent, instance_id = kAbsent;

  uint32_t instance_value = UINT32_MAX;  ///< what a hit outside of instances writes into it

  /// The packet of ray i. Most have a power of two of lanes, by which to divide takes no time.
  std::size_t Packet(std::size_t i) const {
    return std::has_single_bit(lanes) ? i >> std::countr_zero(lanes) : i / lanes;
  }

  /// Address of a component of ray i. `component` must not be kAbsent.
  std::uintptr_t Address(Component component, std::size_t i) const {
    const std::size_t packet = Packet(i);
    const std::uintptr_t start = packets ? reinterpret_cast<std::uintptr_t>(packets[packet])
                                         : static_cast<std::uintptr_t>(packet * packet_stride);
    return start + component + (i - packet * lanes) * lane_stride;
  }
};

/// A packet of 1 to 16 rays in the caller's memory, of which a single ray is one with a single
/// lane: arrays of `lanes` values each, one behind the other, in the order of PacketComponent
/// (callback.h). Query::kAny has those up to kFlags, Query::kClosest all.
///
/// Which rays are active, and what is read and written, is as in RayView.
struct RayPacket {
  void* values = nullptr;  ///< four-byte aligned
  uint32_t lanes = 1;
  const int32_t* valid = nullptr;  ///< lanes with another value than -1 take no part; null: all do
  uint32_t instance_value = UINT32_MAX;  ///< as in RayView
  bool has_masks = true;                 ///< else masks are not read, and all their bits count
};

}  // namespace dacrt
