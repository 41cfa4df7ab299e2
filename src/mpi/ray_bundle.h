// Rays on their way between the ranks of a divided scene: on a rank, and as they travel.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "dacrt/mpi.h"
#include "message.h"
#include "route.h"
#include "view_piece.h"

namespace dacrt::mpi {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A ray, and room for the hit that an engine finds: a record as engines read it fastest.
struct RayRecord {
  // In the order of PacketComponent.
  float org[3], tnear;
  float dir[3], time = 0;
  float tfar;  ///< up to where hits are looked for, then that of the hit
  uint32_t mask = UINT32_MAX;
  uint32_t id = UINT32_MAX, flags = UINT32_MAX;  ///< for callbacks
  float ng[3];
  float u, v;
  uint32_t primitive_id = UINT32_MAX, geometry_id = UINT32_MAX, instance_id = UINT32_MAX;

  HitRecord found() const {
    return {tfar, {ng[0], ng[1], ng[2]}, u, v, primitive_id, geometry_id, instance_id};
  }
};

/// What a ray has with it beside its record: whose it is, and the closest hit so far.
struct Luggage {
  uint32_t home;          ///< the rank
  uint32_t index;         ///< in that rank's call
  float key = kInfinity;  ///< of the hit, see hit_key.h
  HitRecord hit{0, {0, 0, 0}, 0, 0, UINT32_MAX, UINT32_MAX, UINT32_MAX};
  float tfar;  ///< the ray's own

  bool has_hit() const { return hit.primitive_id != UINT32_MAX; }

  /// A hit at the same distance may still win, a farther one not.
  float limit() const { return std::min(tfar, key); }

  /// Up to where hits are looked for: one at the same distance may be the one that counts.
  float FindableTo() const {
    return has_hit() ? std::min(tfar, std::nextafter(key, kInfinity)) : tfar;
  }
};

/// Rays on a rank. Their memory is kept when they are gone.
class Bundle {
 public:
  std::size_t size() const { return size_; }

  /// Only the first `size` are left, or there are more, of undefined contents.
  void Resize(std::size_t size) {
    size_ = size;
    if (records_.size() >= size) return;
    records_.resize(size);
    luggage_.resize(size);
  }

  RayRecord& record(std::size_t i) { return records_[i]; }
  Luggage& luggage(std::size_t i) { return luggage_[i]; }

  void Copy(std::size_t from, std::size_t to) {
    records_[to] = records_[from];
    luggage_[to] = luggage_[from];
  }

  /// For Routes.
  RouteRay route(std::size_t i) const {
    const RayRecord& ray = records_[i];
    return {{ray.org[0], ray.org[1], ray.org[2]},
            {ray.dir[0], ray.dir[1], ray.dir[2]},
            ray.tnear,
            static_cast<int>(luggage_[i].home)};
  }

  /// The records, for an engine.
  RayView View(Query query);

 private:
  std::size_t size_ = 0;
  std::vector<RayRecord> records_;
  std::vector<Luggage> luggage_;
};

/// Which parts of a ray travel: 40 bytes, and up to 56 more.
struct RayKind {
  bool has_mask = false, has_time = false;
  bool for_callbacks = false;
  bool has_hit = false;

  static constexpr std::size_t kKinds = 16;

  uint32_t Bits() const {
    return has_mask | has_time << 1 | for_callbacks << 2 | static_cast<uint32_t>(has_hit) << 3;
  }
  static RayKind FromBits(uint32_t bits) {
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
  uint32_t kind;   ///< RayKind::Bits
  uint32_t count;  ///< of rays; of an answer, of hits
  uint64_t done;   ///< of an answer: rays that go no farther, with a hit or without
};

/// The kind of a ray that goes to another rank.
RayKind KindOf(const RayRecord& ray, const Luggage& luggage, bool for_callbacks);

/// Writes a ray to `to`, of kind.bytes(), and reads it back, ready to be traced.
void PutRay(const RayRecord& ray, const Luggage& luggage, const RayKind& kind, std::byte* to);
void GetRay(const std::byte* from, const RayKind& kind, RayRecord& ray, Luggage& luggage);

/// Ray i of a program's batch, ready to be traced.
void GetRay(const RayView& rays, std::size_t i, uint32_t home, RayRecord& ray, Luggage& luggage);

}  // namespace dacrt::mpi
