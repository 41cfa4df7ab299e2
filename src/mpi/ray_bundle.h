// Rays on their way between the ranks of a divided scene, as they travel: a record for each.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "dacrt/mpi.h"
#include "message.h"
#include "route.h"
#include "view_piece.h"

namespace dacrt::mpi {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A ray, whose it is, and the closest hit that it carries.
struct TravellingRay {
  uint32_t home;          ///< the rank
  uint32_t index;         ///< in that rank's call
  float key = kInfinity;  ///< of the hit, see hit_key.h
  HitRecord hit{0, {0, 0, 0}, 0, 0, UINT32_MAX, UINT32_MAX, UINT32_MAX};

  // In the order of PacketComponent, to its end.
  float org[3], tnear;
  float dir[3], time = 0;
  float tfar;
  uint32_t mask = UINT32_MAX;
  uint32_t id = UINT32_MAX, flags = UINT32_MAX;  ///< for callbacks

  bool has_hit() const { return hit.primitive_id != UINT32_MAX; }

  /// Up to where hits are looked for: one at the same distance as that which it carries may be the
  /// one that counts.
  float FindableTo() const { return std::min(tfar, std::nextafter(key, kInfinity)); }

  /// For Route: a hit at the same distance may still win, a farther one not.
  RouteRay route() const {
    return {{org[0], org[1], org[2]}, {dir[0], dir[1], dir[2]}, tnear, std::min(tfar, key)};
  }
};

/// Which parts of a TravellingRay its record has: 40 bytes, and up to 56 more.
struct RecordKind {
  bool has_mask = false, has_time = false;
  bool for_callbacks = false;
  bool has_hit = false;

  static constexpr std::size_t kKinds = 16;

  uint32_t Bits() const {
    return has_mask | has_time << 1 | for_callbacks << 2 | static_cast<uint32_t>(has_hit) << 3;
  }
  static RecordKind FromBits(uint32_t bits) {
    return {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0};
  }

  std::size_t bytes() const {
    return 40 + 4 * has_mask + 4 * has_time + 8 * for_callbacks + 40 * has_hit;
  }
};

/// What a message of rays begins with, and one of answers.
struct BundleHead {
  uint32_t is_answer;  ///< to the rank whose rays they are
  uint32_t query;
  uint64_t scene;
  uint64_t call;
  uint32_t kind;   ///< RecordKind::Bits
  uint32_t count;  ///< of rays; of an answer, of hits
  uint64_t done;   ///< of an answer: rays that go no farther, with a hit or without
};

/// Writes `ray` to `to`, of kind.bytes(), and reads it back.
void PutRay(const TravellingRay& ray, const RecordKind& kind, std::byte* to);
TravellingRay GetRay(const std::byte* from, const RecordKind& kind);

/// Ray i of a program's batch.
TravellingRay FromView(const RayView& rays, std::size_t i, uint32_t home);

}  // namespace dacrt::mpi
