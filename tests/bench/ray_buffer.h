// The caller's side of a batch: records in memory, as a renderer written for Embree holds them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <span>

#include "dacrt/dacrt.h"

namespace dacrt::bench {

/// One ray and its hit, laid out as Embree 3's RTCRayHit.
struct alignas(16) RayRecord {
  float org[3];
  float tnear;
  float dir[3];
  float time;
  float tfar;
  uint32_t mask;
  uint32_t id;  ///< the number of the camera ray that this one descends from
  uint32_t flags;
  float ng[3];
  float u, v;
  uint32_t primitive_id;
  uint32_t geometry_id;
  uint32_t instance_id;
};
static_assert(sizeof(RayRecord) == 80);

inline constexpr uint32_t kNoGeometry = UINT32_MAX;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A batch of one query. All of its rays end at the same tfar, so that a traced batch can be made
/// ready to be traced again.
class RayBuffer {
 public:
  /// Of the first record: what Embree asks of packets of sixteen rays.
  static constexpr std::size_t kAlignment = 64;

  /// Room for `capacity` rays, of which no page is touched yet.
  explicit RayBuffer(std::size_t capacity);

  /// Empties the buffer for rays of another batch.
  void Begin(float tfar);

  /// Adds a ray that starts at `org` exactly (tnear 0). There must be room.
  void Append(const float (&org)[3], const float (&dir)[3], uint32_t id);

  /// Undoes what a trace wrote: every ray as if it had just been appended.
  void Rearm();

  std::span<RayRecord> rays() { return {records_.get(), size_}; }
  std::span<const RayRecord> rays() const { return {records_.get(), size_}; }

  /// Drops all but the first `count` rays.
  void Keep(std::size_t count) { size_ = count; }

  /// A copy of `count` rays from the `first` on, armed.
  RayBuffer Part(std::size_t first, std::size_t count) const;

  /// Where the records stand, for Scene::Trace.
  RayView View();

 private:
  struct Free {
    void operator()(void* records) const {
      ::operator delete (records, std::align_val_t{kAlignment});
    }
  };

  std::unique_ptr<RayRecord[], Free> records_;
  std::size_t size_ = 0;
  float tfar_ = kInfinity;
};

/// What a trace left in a record, as one number: equal for equal bits, and for misses whatever
/// else the record holds.
uint64_t Fingerprint(Query query, const RayRecord& record);

}  // namespace dacrt::bench
