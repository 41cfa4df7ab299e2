// The engine's own copy of a piece of a batch: structure of arrays, survivors kept by copying.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "dacrt/dacrt.h"
#include "geometry/geometry_table.h"
#include "rays/ray_record.h"

namespace dacrt {

/// Rays [begin, begin + count) of the arrays. begin is a multiple of kMaxLanes. The lanes behind
/// the last ray, up to a full vector, hold inactive rays.
struct RayBlock {
  std::size_t begin;
  std::size_t count;
};

/// Which triangle a ray hits so far, by the ray's number in the piece. Where and how is computed
/// anew when the hits are stored.
struct PaperHit {
  static constexpr uint32_t kNone = UINT32_MAX;
  /// Flag in `geometry`: the distance is the ray's own tfar, not one that an earlier hit set.
  static constexpr uint32_t kAtLimit = 0x80000000u;

  uint32_t primitive;
  uint32_t geometry;  ///< kNone while there is no hit
};

/// Lanes of the widest vector; blocks start at multiples of it on every instruction set, so that
/// the instruction set does not change the memory that a call needs.
inline constexpr std::size_t kMaxLanes = 16;

/// What a triangle test may assume of tfar and tnear in lanes that hold no ray.
inline constexpr float kInactiveTNear = 0.0f;
inline constexpr float kInactiveTFar = -1.0f;

/// Cones around kRays consecutive rays each of the piece, which all start from one point; cone i
/// belongs to slots kRays * i and on. Space partition only.
struct ConicPackets {
  static constexpr std::size_t kRays = 64;

  float apex[3];
  float* axis[3];  ///< of length 1
  float* tangent;  ///< of the angle between the axis and the side
  float* longest;  ///< length of the longest direction
  float* reach;    ///< how far along the axis there is a ray without a closer hit; negative: none
};

/// Arrays over the workspace. Blocks are stacked: a child's block begins where the newest block
/// ends, and is given back when the child has been solved.
struct RayBatch {
  float* org[3];
  float* dir[3];
  float* tnear;
  float* tfar;      ///< shrinks as hits are found; -infinity once an any-hit ray is blocked
  uint32_t* index;  ///< the ray's number in the piece
  std::size_t capacity;
  std::size_t top = 0;  ///< first free slot

  uint8_t* lane_bits;         ///< which rays of its parent a block holds, one bit a ray
  std::size_t bits_top = 0;   ///< first free byte
  std::size_t bits_capacity;  ///< bytes

  PaperHit* hits;      ///< by ray number; closest-hit queries only
  FullHit* full_hits;  ///< the same, where a scene holds more than still triangles;
                       ///< PaperHit::geometry is then all that counts of the other
  uint32_t* ray_masks;  ///< by ray number; null if every ray may meet every geometry

  ConicPackets cones;
  std::span<RayBlock> packets;  ///< stacked lists of packets

  /// What is copied with a ray: the nine fields above.
  static constexpr std::size_t kFields = 9;
};

/// Makes the slots from `end` on, a full vector of them, hold inactive rays.
inline void PadWithInactive(RayBatch& batch, std::size_t end) {
  for (std::size_t slot = end; slot < end + kMaxLanes; ++slot) {
    batch.tnear[slot] = kInactiveTNear;
    batch.tfar[slot] = kInactiveTFar;
  }
}

/// Copies the active rays `first` to `first + count` of `view` into the empty `batch`, in order.
/// Sets batch.ray_masks to null if no ray needs its mask looked at. Returns their block.
/// (The way back, StoreHits, is compiled for each instruction set: see store_hits-inl.h.)
RayBlock LoadRays(const RayView& view, std::size_t first, std::size_t count, Query query,
                  const GeometryTable& geometries, RayBatch& batch);

}  // namespace dacrt
