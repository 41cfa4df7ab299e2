// One call on a divided scene: rays leave, work on those of others, and come home.
#pragma once

#include <deque>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "dacrt/mpi.h"
#include "key_bound.h"
#include "members.h"
#include "ray_bundle.h"

namespace dacrt::mpi {

/// What each rank tells the others of its part of a scene, when all commit it.
struct PartSummary {
  Bounds bounds;
  uint32_t has_callbacks;
  InstructionSet instruction_set;
};

/// What the ranks know of a scene.
struct DividedParts {
  uint64_t number;
  RouteBoxes boxes;      ///< of each rank's part
  bool has_callbacks;    ///< on some rank
  KeyBounds key_bounds;  ///< of this rank's part
};

/// Every ray visits the ranks that it may hit something on, nearest first, and carries the closest
/// hit of these with it. Its home learns of its end, and the call ends when all rays have ended on
/// all ranks. Nothing is written for the program before that.
class DividedCall {
 public:
  DividedCall(Members& members, const LocalScene& local, const DividedParts& parts, uint64_t call,
              std::size_t bundle_rays, Query query, const RayView& rays, const CallOptions& options,
              Traffic& traffic);

  /// Throws what goes wrong, when no ray has changed.
  void Run();

  /// Writes the hits into the program's records.
  void Store() const;

 private:
  /// A ray that is traced here. The hit that is found stands behind the ray, so that both together
  /// are a record as engines read them fastest.
  struct Visitor {
    TravellingRay ray;
    float found_ng[3];
    float found_u, found_v;
    uint32_t found_primitive, found_geometry, found_instance;
    float found_t;  ///< until it has been traced the ray's own tfar, and that of the record here
    float found_key;
    bool ends_here;  ///< its hit is final

    bool has_found() const { return found_primitive != UINT32_MAX; }
    HitRecord found() const {
      return {found_t,         {found_ng[0], found_ng[1], found_ng[2]},
              found_u,         found_v,
              found_primitive, found_geometry,
              found_instance};
    }
  };
  struct Bucket {
    Message message;
    uint32_t count = 0;
  };
  using IndexedHit = std::pair<uint32_t, HitRecord>;  ///< and the ray that has it
  struct Answers {
    uint64_t done = 0;
    std::vector<IndexedHit> hits;
  };

  bool TakeMessages();
  void TakeAnswers(Reader& reader, const BundleHead& head);
  bool Work();
  void SendOwnRays();
  void TraceBundle(const Message& bundle);
  void Trace(std::span<Visitor> visitors);
  void FindKeysOf(std::span<Visitor> visitors);
  /// Whether the hit that a ray has found here is where it ends, whatever its key is.
  bool GoesNoFarther(const Visitor& visitor);
  /// Where a ray goes from here; a hit that was found here counts.
  int NextOf(const Visitor& visitor);
  void Dispatch(const TravellingRay& ray, RecordKind kind, int next);
  void End(const TravellingRay& ray);
  void KeepHit(uint32_t index, const HitRecord& hit);
  void StoreOne(uint32_t index, HitRecord hit) const;
  void Flush(std::size_t number, Bucket& bucket);
  void FlushAll();
  void SendAnswers(int home, Answers& answers);
  BundleHead Head() const;

  Members& members_;
  Link& link_;
  const LocalScene& local_;
  const DividedParts& parts_;
  const uint64_t call_;
  const std::size_t bundle_rays_;
  const Query query_;
  const RayView& rays_;
  const CallOptions& options_;
  Traffic& traffic_;
  const int tag_;

  Route route_;
  std::size_t next_own_ = 0;  ///< of the rays of this rank, the first that has not left
  std::size_t ended_ = 0;     ///< of these, how many go no farther
  std::deque<std::vector<IndexedHit>> own_hits_;
  std::deque<Message> work_;
  std::vector<Visitor> visitors_;   ///< room for those of a bundle
  std::vector<Bucket> buckets_;     ///< by the rank that they go to and RecordKind::Bits
  std::map<int, Answers> answers_;  ///< by home
};

}  // namespace dacrt::mpi
