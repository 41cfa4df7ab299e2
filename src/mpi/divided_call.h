// One call on a divided scene: rays leave, work on those of others, and come home.
#pragma once

#include <deque>
#include <vector>

#include "dacrt/mpi.h"
#include "hit_key.h"
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
              std::size_t bundle_rays, Bundle& room, Query query, const RayView& rays,
              const CallOptions& options, Traffic& traffic);

  /// Throws what goes wrong, when no ray has changed.
  void Run();

  /// Writes the hits into the program's records.
  void Store();

 private:
  /// What is on its way to a rank, in parts: rays of one kind, or answers.
  struct Outgoing {
    Message message;
    uint32_t count = 0;
    uint64_t done = 0;  ///< of answers: rays that go no farther, with a hit or without
  };

  bool TakeMessages();
  void TakeAnswers(Message message, const BundleHead& head);
  bool Work();
  void TakeOwnRays();
  void TakeBundle(const Link::Arrival& arrival);

  /// Traces the rays that are here and sends them on.
  void TraceBundle();
  void TraceHere();
  void SendOn(std::size_t first, std::size_t end);
  /// The same of rays whose hits need their keys.
  void SendOnWithKeys();
  void SetRoutes(std::size_t first, std::size_t end);
  /// Makes the hit that was found for a ray the one that it carries, if it is closer.
  void Merge(std::size_t i, float key);
  void Dispatch(std::size_t i, int next);
  void End(std::size_t i, bool has_hit, const HitRecord& hit);

  std::size_t BytesOfHit() const;
  std::byte* Append(Outgoing& outgoing, std::size_t bytes);
  void SendRays(std::size_t number, Outgoing& outgoing);
  void SendAnswers(int home, Outgoing& outgoing);
  void SendAll();
  Message Finish(Outgoing& outgoing, BundleHead head);

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

  Routes routes_;
  std::size_t next_own_ = 0;  ///< of the rays of this rank, the first that nothing was done for
  std::size_t ended_ = 0;     ///< of these, how many go no farther
  std::vector<Message> own_hits_;  ///< answers to this rank
  std::deque<Link::Arrival> work_;
  Bundle& bundle_;                     ///< the rays that are here
  std::vector<FoundHit> unsure_;       ///< of these: which have to know the key of their hit
  std::vector<Outgoing> rays_out_;     ///< by the rank that they go to and RayKind::Bits
  std::vector<Outgoing> answers_out_;  ///< by home
};

}  // namespace dacrt::mpi
